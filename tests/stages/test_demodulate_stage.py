import torch

from supersampling.frames import Frame
from supersampling.ops.display import displayed
from supersampling.stages.demodulate import Demodulated, Radiance


def light(*shape, low=0.0):
    return torch.rand(*shape, dtype=torch.float64) + low


def test_lighting_is_radiance_without_emission_over_material():
    torch.manual_seed(0)
    material, emission, lighting = light(2, 3, 4, 5, low=0.1), light(2, 3, 4, 5), 9.0 * light(2, 3, 4, 5)
    frame = Frame(radiance=material * lighting + emission, material=material, emission=emission)
    torch.testing.assert_close(Demodulated()(frame), lighting)


def test_a_perfect_output_is_presented_as_the_display_of_the_target():
    torch.manual_seed(0)
    clip = {"target_radiance": 3.0 * light(2, 4, 3, 6, 6)}
    clip["high_emission"] = clip["target_radiance"] * (
        light(2, 4, 1, 6, 6) > 0.8
    )  # sky: all of it passes beside
    clip["high_material"] = light(2, 4, 3, 6, 6, low=0.05) * (clip["high_emission"] == 0)
    for stage in (Demodulated(), Radiance()):
        given = {name: clip[name] for name in stage.compares}
        reference = stage.reference(given)
        assert reference.shape == clip["target_radiance"].shape
        for t in range(4):
            image = stage.present(reference[:, t], Frame.of(given, t))
            torch.testing.assert_close(image, displayed(clip["target_radiance"][:, t]))


def test_negative_outputs_are_no_light_and_do_not_darken_emission():
    emission = light(1, 3, 2, 2)
    frame = Frame(high_material=torch.ones_like(emission), high_emission=emission)
    shown = Demodulated().present(-torch.ones_like(emission), frame)
    assert torch.equal(shown, displayed(emission))


def test_off_reads_the_radiance_alone():
    radiance = light(1, 3, 2, 2)
    assert Radiance().requires == {"radiance"}
    assert Radiance().compares == {"target_radiance"}
    assert torch.equal(Radiance()(Frame(radiance=radiance)), radiance)


def test_what_is_presented_is_among_what_is_required():
    """Scoring loads what is required, and no reference beside the target."""
    assert Demodulated().requires == {"radiance", "material", "emission", "high_material", "high_emission"}
