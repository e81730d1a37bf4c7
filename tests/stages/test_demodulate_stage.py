import math

import pytest
import torch

from supersampling.frames import Frame
from supersampling.ops.display import radiance_to_display
from supersampling.stages.demodulate import Demodulated, DisplayColour, LoggedLighting, LoggedRadiance, Radiance


def light(*shape, low=0.0):
    return torch.rand(*shape, dtype=torch.float64) + low


def test_lighting_is_radiance_without_emission_over_material():
    torch.manual_seed(0)
    material, emission, lighting = light(2, 3, 4, 5, low=0.1), light(2, 3, 4, 5), 9.0 * light(2, 3, 4, 5)
    frame = Frame(radiance=material * lighting + emission, material=material, emission=emission)
    torch.testing.assert_close(Demodulated()(frame), lighting)


def test_perfect_output_is_presented_as_the_target():
    torch.manual_seed(0)
    clip = {"target_radiance": 3.0 * light(2, 4, 3, 6, 6)}
    clip["high_emission"] = clip["target_radiance"] * (
        light(2, 4, 1, 6, 6) > 0.8
    )  # sky: all of it bypasses the network
    clip["high_material"] = light(2, 4, 3, 6, 6, low=0.05) * (clip["high_emission"] == 0)
    for stage in (Demodulated(), LoggedLighting(), Radiance(), LoggedRadiance()):
        buffers = {name: clip[name] for name in stage.compares}
        reference = stage.reference(buffers)
        assert reference.shape == clip["target_radiance"].shape
        for t in range(4):
            image = stage.present(reference[:, t], Frame.from_clip(buffers, t))
            torch.testing.assert_close(image, radiance_to_display(clip["target_radiance"][:, t]))


def test_negative_outputs_do_not_darken_emission():
    emission = light(1, 3, 2, 2)
    frame = Frame(high_material=torch.ones_like(emission), high_emission=emission)
    shown = Demodulated().present(-torch.ones_like(emission), frame)
    assert torch.equal(shown, radiance_to_display(emission))


def test_logged_lighting_is_the_logarithm_of_lighting_and_does_not_overflow():
    lighting = torch.tensor([0.0, 1e-6, 0.5, 3000.0], dtype=torch.float64).expand(1, 3, 1, 4)
    one, none = torch.ones_like(lighting), torch.zeros_like(lighting)
    stage = LoggedLighting()
    lit = stage(Frame(radiance=lighting, material=one, emission=none))
    assert lit[0, 0, 0].tolist() == pytest.approx([0.0, 1e-6, math.log(1.5), math.log(3001.0)], rel=1e-5)
    shown = stage.present(torch.full_like(one, 1e4), Frame(high_material=one, high_emission=none))
    torch.testing.assert_close(shown, one)


def test_logged_radiance_is_logged_lighting_of_a_white_material_that_does_not_glow():
    """The two options differ in the material only: input, reference of the loss and image are the same without one."""
    torch.manual_seed(0)
    clip = {"target_radiance": 9.0 * light(2, 4, 3, 6, 6)}
    clip["high_material"] = torch.ones_like(clip["target_radiance"])
    clip["high_emission"] = torch.zeros_like(clip["target_radiance"])
    on, off = LoggedLighting(), LoggedRadiance()
    low = {"radiance": clip["target_radiance"], "material": clip["high_material"], "emission": clip["high_emission"]}
    torch.testing.assert_close(off(Frame.from_clip(low, 1)), on(Frame.from_clip(low, 1)))
    torch.testing.assert_close(off.reference(clip), on.reference(clip))
    output = 20.0 * light(2, 3, 6, 6) - 5.0  # negative, and beyond the largest half
    frame = Frame.from_clip(clip, 1)
    torch.testing.assert_close(off.radiance(output, frame), on.radiance(output, frame))
    torch.testing.assert_close(off.present(output, frame), on.present(output, frame))
    assert off.requires == {"radiance"}
    assert off.compares == {"target_radiance"}
    assert off(Frame(radiance=torch.tensor([0.0, 1.5, 3000.0]))).tolist() == pytest.approx(
        [0.0, math.log(2.5), math.log(3001.0)]
    )


def test_none_reads_radiance_only():
    radiance = light(1, 3, 2, 2)
    assert Radiance().requires == {"radiance"}
    assert Radiance().compares == {"target_radiance"}
    assert torch.equal(Radiance()(Frame(radiance=radiance)), radiance)


def test_display_colour_is_presented_unchanged_within_its_range():
    stage = DisplayColour()
    clip = {"color": light(2, 3, 3, 4, 4), "target": light(2, 3, 3, 8, 8)}
    assert stage.requires == {"color"}
    assert stage.compares == {"target"}
    assert torch.equal(stage(Frame.from_clip(clip, 1)), clip["color"][:, 1])
    assert torch.equal(stage.reference(clip), clip["target"])
    beyond = torch.tensor([-0.5, 0.0, 0.3, 1.0, 1.5])
    assert stage.present(beyond, Frame()).tolist() == torch.tensor([0.0, 0.0, 0.3, 1.0, 1.0]).tolist()


def test_buffers_of_present_are_required():
    """Scoring loads required buffers, and no reference except the target."""
    assert Demodulated().requires == {"radiance", "material", "emission", "high_material", "high_emission"}
