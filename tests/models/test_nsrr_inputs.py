"""NSRR's inputs and outputs: display colour, light or lighting, and guides (NSRD, table 5)."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate
from nsrr_transcription import clip, nsrr, run, transcribed

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.ops.display import radiance_to_display
from supersampling.stages.colour_space import RGB, YCbCr
from supersampling.stages.demodulate import Demodulated, Radiance
from supersampling.stages.guides import GBuffers

CONF = Path(__file__).resolve().parents[2] / "conf"
ALWAYS = {"depth", "jitter", "motion"}
LIGHTING = {"radiance", "material", "emission", "high_material", "high_emission"}
READ = {
    (): {"color"},
    ("model/demodulate=display", "model/guides=none"): {"color"},
    ("model/demodulate=none",): {"radiance"},
    ("model/demodulate=lighting",): LIGHTING,
    ("model/guides=gbuffers",): {"color", "normal"},
    ("model/demodulate=lighting", "model/colour_space=rgb", "model/guides=gbuffers",
     "model.guides.names=[normal,albedo]"): LIGHTING | {"normal", "albedo"},
    ("model/guides=gbuffers", "model.guides.names=[roughness]", "model.previous=1", "model/extract=none"):
        {"color", "roughness"},
}  # fmt: skip


def lit(frames=3, b=2, h=5, w=6, scale=2, dtype=torch.float32):
    """Return the buffers of `nsrr_transcription.clip`, light, guides and references."""
    g = torch.Generator().manual_seed(2)

    def rand(channels, s=1):
        return torch.rand(b, frames, channels, h * s, w * s, generator=g, dtype=dtype)

    buffers = clip(frames, b, h, w, dtype=dtype)
    buffers |= {"emission": rand(3) * 0.2, "material": rand(3) * 0.9 + 0.1, "albedo": rand(3), "roughness": rand(1)}
    buffers["radiance"] = buffers["material"] * rand(3) * 4.0 + buffers["emission"]
    buffers["normal"] = torch.nn.functional.normalize(rand(3) - 0.5, dim=2)
    buffers |= {"target": rand(3, scale), "high_emission": rand(3, scale) * 0.2}
    buffers["high_material"] = rand(3, scale) * 0.9 + 0.1
    buffers["target_radiance"] = buffers["high_material"] * rand(3, scale) * 4.0 + buffers["high_emission"]
    return buffers


def only(buffers, names):
    return {name: values for name, values in buffers.items() if name in names}


@torch.no_grad()
def test_lighting_replaces_colour_and_guides_follow_depth():
    model = nsrr(2, 3, width=8, demodulate=Demodulated(), guides=GBuffers(["normal", "roughness"])).double()
    for p in model.parameters():
        p.add_(torch.randn_like(p) * 0.05)  # biases too
    buffers = lit(frames=5, dtype=torch.float64)
    outputs, _ = run(model, only(buffers, model.requires))
    lighting = (buffers["radiance"] - buffers["emission"]) / buffers["material"]
    for t in range(5):
        expected = transcribed(model, {**buffers, "color": lighting}, t, 3, 2, ("normal", "roughness"))
        torch.testing.assert_close(outputs[:, t], expected, rtol=0, atol=1e-9)
    assert outputs.std() > 0.01


@pytest.mark.parametrize("colour_space", [RGB(), YCbCr()])
@pytest.mark.parametrize("demodulate", [Demodulated(), Radiance()])
def test_perfect_output_is_displayed_as_the_target(demodulate, colour_space):
    model = nsrr(2, 1, width=4, demodulate=demodulate, colour_space=colour_space)
    buffers = lit()
    compared = model.reference(only(buffers, model.compares))
    frame = Frame.from_clip(only(buffers, model.requires), 1)
    shown = model.present(compared[:, 1], frame)
    torch.testing.assert_close(shown, radiance_to_display(buffers["target_radiance"][:, 1]), rtol=0, atol=1e-5)
    assert compared.max() > 1.0


def test_black_material_and_no_light_have_finite_gradients():
    model = nsrr(2, 2, width=8, demodulate=Demodulated())
    buffers = only(lit(), model.requires)
    buffers["material"][..., :3, :] = 0.0
    buffers["radiance"][..., 2:4] = 0.0
    buffers["radiance"].requires_grad_()
    run(model, buffers)[0].square().mean().backward()
    assert buffers["radiance"].grad.isfinite().all()
    assert all(p.grad.isfinite().all() for p in model.parameters())


@pytest.fixture
def model_of():
    def make(*overrides):
        GlobalHydra.instance().clear()
        with initialize_config_dir(str(CONF), version_base="1.3"):
            cfg = compose("train", ["scene=atrium", "model=nsrr", "task.scale=2", *overrides])
        torch.manual_seed(0)
        return instantiate(cfg.model)

    return make


@pytest.mark.parametrize("name", ["nsrr", "nsrr_fast"])
@pytest.mark.parametrize("overrides", READ, ids=" ".join)
def test_every_option_composes_declares_its_buffers_and_trains(model_of, overrides, name):
    model, buffers = model_of(f"model={name}", "model.width=16", *overrides), lit()
    assert model.requires == READ[overrides] | ALWAYS
    inputs_of_model, compared = only(buffers, model.requires), model.reference(only(buffers, model.compares))
    optimizer = torch.optim.Adam(model.parameters(), 1e-4)
    losses = []
    for _ in range(2):
        outputs, _ = run(model, inputs_of_model)
        loss = (outputs - compared).square().mean()
        optimizer.zero_grad()
        loss.backward()
        assert all(p.grad is not None and p.grad.isfinite().all() for p in model.parameters())
        optimizer.step()
        losses.append(loss.item())
    assert losses[1] < losses[0]
    shown = model.present(outputs[:, -1], Frame.from_clip(inputs_of_model, 2))
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0


@pytest.mark.parametrize("buffer", ["radiance", "material", "emission", "normal", "albedo"])
@torch.no_grad()
def test_every_declared_buffer_changes_the_output(buffer):
    model = nsrr(2, 2, width=8, demodulate=Demodulated(), guides=GBuffers(["normal", "albedo"]))
    buffers = only(lit(), model.requires)
    changed = {**buffers, buffer: buffers[buffer].flip(-1)}
    assert not torch.equal(run(model, changed)[0], run(model, buffers)[0])


def test_invalid_guide_on_the_command_line_raises(model_of):
    with pytest.raises(Exception, match="high_normal") as caught:
        model_of("model/guides=gbuffers", "model.guides.names=[high_normal]")
    assert isinstance(caught.value, UserError) or isinstance(caught.value.__cause__, UserError)


@torch.no_grad()
def test_exports_to_a_graph_with_light_and_guides():
    model = nsrr(2, 2, width=4, demodulate=Demodulated(), guides=GBuffers(["normal"])).eval()
    buffers = lit(frames=2, b=1)
    names = sorted(n for n in model.requires if not n.startswith("high_"))
    _, state = model(Frame.from_clip(only(buffers, names), 0), None)
    inputs = tuple(buffers[name][:, 1] for name in names)

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, inputs, state):
            return self.model(Frame(**dict(zip(names, inputs, strict=True))), state)

    exported = torch.export.export(Step(), (inputs, state)).module()
    output, after = exported(inputs, state)
    expected, expected_after = model(Frame.from_clip(only(buffers, names), 1), state)
    torch.testing.assert_close(output, expected)
    torch.testing.assert_close(after, expected_after)
