"""What every model keeps, at every scale; and that every configuration file composes into one."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from supersampling.frames import Frame

CONF = Path(__file__).parents[2] / "conf"
SCALES = [2, 3, 4, 5, 6]
STAGES = {
    "tus": ("reproject", "rectify", "dilate", "pad"),
    "dlctus": ("reproject", "dilate", "pad", "accumulate", "confine", "initialise"),
}
VARIANTS = [("bicubic", ()), ("jau", ())] + [
    (model, (f"model/{slot}={option.stem}",))
    for model, slots in STAGES.items()
    for slot in slots
    for option in sorted((CONF / "model" / slot).glob("*.yaml"))
]
RECURRENT = ("tus", "dlctus")


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    root = tmp_path_factory.mktemp("conf")
    (root / "root.yaml").write_text(
        "defaults:\n  - model: jau\n  - loss: l1\n  - _self_\ntask:\n  scale: 4\n"
        f"hydra:\n  searchpath:\n    - file://{CONF}\n"
    )

    def make(group, *overrides):
        with initialize_config_dir(str(root), version_base="1.3"):
            config = compose("root", overrides=list(overrides))
        torch.manual_seed(0)
        return instantiate(config[group])

    return make


@pytest.fixture(scope="module")
def model_of(build):
    return lambda name, scale, *overrides: build("model", f"model={name}", f"task.scale={scale}", *overrides)


def clip(frames=3, b=2, h=5, w=6, seed=0, motion=0.1):
    g = torch.Generator().manual_seed(seed)
    return {
        "color": torch.rand(b, frames, 3, h, w, generator=g),
        "depth": torch.rand(b, frames, 1, h, w, generator=g),
        "motion": torch.randn(b, frames, 2, h, w, generator=g) * motion,
        "jitter": torch.rand(b, frames, 2, generator=g) - 0.5,
    }


def run(model, buffers, items=slice(None)):
    """Outputs ``(B, T, 3, H, W)`` from the buffers that the model asks for and no other."""
    given = {name: buffer[items] for name, buffer in buffers.items() if name in model.requires}
    outputs, state = [], None
    for t in range(given["color"].shape[1]):
        output, state = model(Frame.of(given, t), state)
        outputs.append(output)
    return torch.stack(outputs, dim=1)


@pytest.mark.parametrize(("name", "overrides"), VARIANTS)
def test_every_stage_gives_an_image_in_range_and_items_do_not_mix(model_of, name, overrides):
    model, buffers = model_of(name, 2, *overrides), clip()
    with torch.no_grad():
        outputs = run(model, buffers)
        alone = run(model, buffers, slice(1, 2))
    assert outputs.shape == (2, 3, 3, 10, 12)
    assert outputs.dtype == torch.float32
    assert outputs.min() >= 0.0
    assert outputs.max() <= 1.0
    torch.testing.assert_close(alone[0], outputs[1], rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["bicubic", "jau", "tus", "dlctus"])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(("h", "w"), [(1, 1), (3, 5)])
def test_every_scale_and_size_from_one_pixel_up(model_of, name, scale, h, w):
    with torch.no_grad():
        outputs = run(model_of(name, scale), clip(h=h, w=w))
    assert outputs.shape == (2, 3, 3, h * scale, w * scale)
    assert outputs.isfinite().all()
    assert outputs.min() >= 0.0
    assert outputs.max() <= 1.0


@pytest.mark.parametrize(("name", "overrides"), VARIANTS)
def test_gradients_are_finite_and_reach_the_first_frame_of_recurrent_models(model_of, name, overrides):
    model, buffers = model_of(name, 2, *overrides), clip()
    buffers["color"].requires_grad_()
    run(model, buffers)[:, -1].mean().backward()
    assert buffers["color"].grad.isfinite().all()
    first = buffers["color"].grad[:, 0].abs().max()
    assert (first > 0) == (name in RECURRENT)
    for parameter in model.parameters():
        assert parameter.grad is not None
        assert parameter.grad.isfinite().all()


@pytest.mark.parametrize("name", ["bicubic", "jau", "tus", "dlctus"])
def test_nothing_that_is_not_declared_changes_the_output(model_of, name):
    model, buffers = model_of(name, 2), clip()
    with torch.no_grad():
        outputs = run(model, buffers)
        other = clip(seed=1)
        mixed = {k: buffers[k] if k in model.requires else other[k] for k in buffers}
        state, everything = None, []
        for t in range(3):
            output, state = model(Frame.of(mixed, t), state)
            everything.append(output)
    assert torch.equal(torch.stack(everything, dim=1), outputs)


@pytest.mark.parametrize("buffer", ["color", "depth", "motion", "jitter"])
@pytest.mark.parametrize("name", ["bicubic", "jau", "tus", "dlctus"])
def test_everything_that_is_declared_changes_the_output(model_of, name, buffer):
    model, buffers = model_of(name, 2), clip()
    if buffer not in model.requires:
        assert buffer == "depth" or name in ("bicubic", "jau")
        return
    with torch.no_grad():
        changed = run(model, {**buffers, buffer: clip(seed=1)[buffer]})
        assert not torch.equal(changed, run(model, buffers))


@pytest.mark.parametrize("name", RECURRENT)
def test_the_state_carries_what_earlier_frames_saw(model_of, name):
    model, buffers = model_of(name, 2, *(["model.alpha=0.5"] if name == "tus" else [])), clip()
    with torch.no_grad():
        with_history = run(model, buffers)[:, 1]
        without = run(model, {k: v[:, 1:2] for k, v in buffers.items()})[:, 0]
    assert (with_history - without).abs().max() > 0.01


@pytest.mark.parametrize(("name", "overrides"), VARIANTS)
def test_a_flat_still_scene_stays_what_it_is(model_of, name, overrides):
    """Whatever the weights: a blend of one colour with itself is that colour."""
    model, buffers = model_of(name, 2, *overrides), clip(frames=8, motion=0.0)
    buffers["color"] = torch.tensor([0.2, 0.5, 0.8]).view(3, 1, 1).expand_as(buffers["color"])
    with torch.no_grad():
        outputs = run(model, buffers)
    torch.testing.assert_close(outputs, buffers["color"][:, :, :, :1, :1].expand_as(outputs))


@pytest.mark.parametrize("name", RECURRENT)
def test_a_still_scene_under_one_jitter_converges(model_of, name):
    one = clip(frames=1, motion=0.0)
    buffers = {k: v.expand(-1, 60, *v.shape[2:]) for k, v in one.items()}
    with torch.no_grad():
        change = run(model_of(name, 2), buffers).diff(dim=1).abs().amax((0, 2, 3, 4))
    assert change[-1] < 1e-4
    assert change[-1] <= change[0]


@pytest.mark.parametrize(
    ("override", "name"), [("loss=l1", "L1"), ("loss=spatiotemporal loss.theta=0.5", "SpatioTemporal")]
)
def test_losses_compose(build, override, name):
    loss = build("loss", *override.split())
    assert type(loss).__name__ == name
    assert getattr(loss, "theta", 0.5) == 0.5


def test_the_command_line_reaches_into_a_stage(model_of):
    model = model_of(
        "dlctus", 3, "model/reproject=bicubic5", "model.reproject.a=-0.5", "model/accumulate=none"
    )
    assert model.scale == 3
    assert model.reproject.a == -0.5
    assert model.accumulate.channels == 3
