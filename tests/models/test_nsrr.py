"""NSRR against a transcription of Xiao et al. 2020, section 3.2, which warps every window from its first frame."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from nsrr_transcription import clip, nsrr, run, transcribed

from supersampling.frames import Frame
from supersampling.stages.colour_space import RGB
from supersampling.stages.extract import NoExtraction
from supersampling.stages.reweight import NoReweighting
from supersampling.stages.upsample import BilinearUpsampling, ZeroUpsampling
from supersampling.stages.warp_at import LowResolution, TargetResolution

CONF = Path(__file__).parents[2] / "conf"
SLOTS = ("extract", "upsample", "warp_at", "reweight", "colour_space")
VARIANTS = [
    ("nsrr",),
    ("nsrr_fast",),
    ("nsrr", "model/extract=none", "model/reweight=none"),
    ("nsrr", "model/upsample=bilinear", "model/warp_at=low"),
    *(("nsrr", f"model.previous={n}") for n in range(4)),
    *(("nsrr", f"model/{slot}={p.stem}") for slot in SLOTS for p in sorted((CONF / "model" / slot).glob("*.yaml"))),
]


@pytest.mark.parametrize(("scale", "previous"), [(4, 4), (3, 2), (2, 1)])
@torch.no_grad()
def test_one_warp_per_step_equals_the_window_of_the_paper(scale, previous):
    model = nsrr(scale, previous, width=8).double()
    for p in model.parameters():
        p.add_(torch.randn_like(p) * 0.05)  # biases too
    buffers = clip(frames=7, dtype=torch.float64)
    outputs, _ = run(model, buffers)
    for t in range(7):
        expected = transcribed(model, buffers, t, previous, scale)
        torch.testing.assert_close(outputs[:, t], expected, rtol=0, atol=1e-9)
    assert outputs.std() > 0.01


@torch.no_grad()
def test_samples_of_a_sliding_plane_land_where_the_plane_is_now():
    """A pattern slides by whole target pixels from sampled pixel centres: warped samples equal this frame's pixels."""
    n, size, velocity = 4, 12, (-3, 2)
    places = torch.tensor([(0, 0), (2, 1), (1, 3), (3, 2), (0, 2), (1, 0)])

    def plane(x, y, t):
        x, y = x - velocity[0] * t, y - velocity[1] * t
        return torch.stack([0.5 + 0.4 * torch.sin(0.3 * x + c + 0.2 * (c - 1) * y) for c in (0.0, 1.0, 2.0)])

    centres = torch.arange(4 * size, dtype=torch.float64) + 0.5
    frames = []
    for t, (x, y) in enumerate(places.tolist()):
        color = plane(centres[None, x::4], centres[y::4, None], t)
        motion = torch.tensor(velocity).double().neg().div(4 * size)
        frames.append(
            Frame(
                color=color[None],
                depth=torch.ones(1, 1, size, size).double(),  # marks sampled pixels
                motion=motion.view(1, 2, 1, 1).expand(1, 2, size, size),
                jitter=(places[t : t + 1] + 0.5) / 4 - 0.5 + torch.zeros(1).double(),
            )
        )
    model = nsrr(4, n, width=2, extract=NoExtraction, reweight=NoReweighting, colour_space=RGB()).double()
    inputs_of_net, state = [], None
    model.reconstruct.register_forward_pre_hook(lambda module, inputs: inputs_of_net.append(inputs[0]))
    for frame in frames:
        _, state = model(frame, state)
    target = plane(centres, centres[:, None], len(frames) - 1)
    covered = torch.zeros(4 * size, 4 * size)
    for k, image in enumerate(inputs_of_net[-1][0].split(4)):
        hit = image[3] > 0.5
        assert hit.sum() > 0.3 * size**2 if k else hit.sum() == size**2
        torch.testing.assert_close(image[:3, hit], target[:, hit], rtol=0, atol=1e-9)
        covered += hit
    assert (covered > 0).sum() > 2.5 * size**2


@torch.no_grad()
def test_zero_motion_leaves_the_window_unchanged():
    model, buffers = nsrr(3, 2, width=4), clip(frames=3, motion=0.0)
    _, first = model(Frame.from_clip(buffers, 0), None)
    _, second = model(Frame.from_clip(buffers, 1), first)
    _, third = model(Frame.from_clip(buffers, 2), second)
    assert torch.equal(second[0][:, 12:], first[0][:, :12])
    assert torch.equal(third[0][:, 12:], second[0][:, :12])
    assert third[0].shape == (2, 24, 15, 18)


@torch.no_grad()
def test_first_frame_stands_in_for_previous_frames():
    model, buffers = nsrr(2, 3, width=4), clip(frames=1, motion=0.0)
    still = {name: values.expand(-1, 5, *values.shape[2:]) for name, values in buffers.items()}
    outputs, _ = run(model, still)
    for t in range(1, 5):
        torch.testing.assert_close(outputs[:, t], outputs[:, 0], rtol=0, atol=1e-6)


def test_gradients_reach_exactly_the_frames_of_the_window():
    model, buffers = nsrr(2, 2, width=8), clip(frames=5)
    buffers["color"].requires_grad_()
    run(model, buffers)[0][:, -1].square().mean().backward()
    reach = buffers["color"].grad.abs().amax((0, 2, 3, 4))
    assert buffers["color"].grad.isfinite().all()
    assert (reach > 0).tolist() == [False, False, True, True, True]


@pytest.mark.parametrize("warp_at", [TargetResolution(), LowResolution()])
@pytest.mark.parametrize("upsample", [ZeroUpsampling(), BilinearUpsampling()])
@torch.no_grad()
def test_translation_by_whole_pixels_commutes_away_from_borders(warp_at, upsample):
    model = nsrr(4, 2, width=4, upsample=upsample, warp_at=warp_at).double()
    buffers = clip(frames=3, b=1, h=40, w=40, motion=0.02, dtype=torch.float64)
    moved = {n: v if n == "jitter" else v.roll((3, -2), (-2, -1)) for n, v in buffers.items()}
    here, there = run(model, buffers)[0], run(model, moved)[0]
    inner = (..., slice(72, 88), slice(72, 88))
    torch.testing.assert_close(there.roll((-12, 8), (-2, -1))[inner], here[inner], rtol=0, atol=1e-10)
    assert here[inner].std() > 1e-3


@pytest.mark.parametrize("scale", [2, 3, 4, 5, 6])
@pytest.mark.parametrize(("h", "w"), [(1, 1), (3, 5)])
@pytest.mark.parametrize("warp_at", [TargetResolution(), LowResolution()])
@torch.no_grad()
def test_every_scale_and_size(scale, h, w, warp_at):
    outputs, _ = run(nsrr(scale, width=4, warp_at=warp_at), clip(h=h, w=w))
    assert outputs.shape == (2, 3, 3, h * scale, w * scale)
    assert outputs.isfinite().all()


@pytest.fixture(scope="module")
def model_of(tmp_path_factory):
    root = tmp_path_factory.mktemp("conf")
    (root / "root.yaml").write_text(
        f"defaults:\n  - model: nsrr\n  - _self_\ntask:\n  scale: 2\nhydra:\n  searchpath:\n    - file://{CONF}\n"
    )

    def make(name, *overrides):
        with initialize_config_dir(str(root), version_base="1.3"):
            config = compose("root", overrides=[f"model={name}", *overrides])
        torch.manual_seed(0)
        return instantiate(config.model)

    return make


@pytest.mark.parametrize("variant", VARIANTS, ids=" ".join)
def test_every_option_composes_trains_and_does_not_mix_items(model_of, variant):
    model, buffers = model_of(*variant), clip()
    buffers = {name: values for name, values in buffers.items() if name in model.requires}
    target = {"target": torch.rand(2, 1, 3, 10, 12)}
    optimizer = torch.optim.Adam(model.parameters(), 1e-4)
    losses = []
    for _ in range(2):
        outputs, _ = run(model, buffers)
        loss = (outputs[:, -1:] - model.reference(target)).square().mean()
        optimizer.zero_grad()
        loss.backward()
        for parameter in model.parameters():
            assert parameter.grad is not None
            assert parameter.grad.isfinite().all()
        optimizer.step()
        losses.append(loss.item())
    assert losses[1] < losses[0]
    with torch.no_grad():
        alone, _ = run(model, {name: values[1:] for name, values in buffers.items()})
        both, _ = run(model, buffers)
    torch.testing.assert_close(alone[0], both[1], rtol=0, atol=1e-5)
    shown = model.present(both[:, -1], Frame())
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0


@pytest.mark.parametrize("buffer", ["color", "depth", "motion", "jitter"])
@torch.no_grad()
def test_every_declared_buffer_changes_the_output(buffer):
    model, buffers = nsrr(2, 2, width=8), clip()
    changed = {**buffers, buffer: clip(seed=1)[buffer]}
    assert not torch.equal(run(model, changed)[0], run(model, buffers)[0])


def test_a_training_in_ycbcr_is_shown_in_rgb():
    model, target = nsrr(2, 1, width=4), torch.rand(2, 3, 3, 8, 8)
    compared = model.reference({"target": target})
    assert (compared - target).abs().max() > 0.1
    torch.testing.assert_close(model.present(compared[:, 0], Frame()), target[:, 0], rtol=0, atol=1e-6)
    assert torch.equal(nsrr(2, 1, width=4, colour_space=RGB()).reference({"target": target}), target)


@pytest.mark.parametrize("warp_at", [TargetResolution(), LowResolution()])
def test_half_precision_keeps_a_state_of_full_precision(warp_at):
    model, buffers = nsrr(2, 2, width=8, warp_at=warp_at), clip()
    with torch.autocast("cpu", torch.bfloat16):
        outputs, state = run(model, buffers)
    full, _ = run(model, buffers)
    assert state[0].dtype == torch.float32
    assert (outputs - full).abs().max() < 0.05 * full.abs().max()
    outputs.float().mean().backward()
    assert all(p.grad.isfinite().all() for p in model.parameters())


@pytest.mark.parametrize("warp_at", [TargetResolution(), LowResolution()])
@torch.no_grad()
def test_exports_to_a_graph(warp_at):
    model, buffers = nsrr(2, 2, width=4, warp_at=warp_at).eval(), clip(frames=2, b=1)
    _, state = model(Frame.from_clip(buffers, 0), None)
    inputs = tuple(values[:, 1] for values in buffers.values())

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, color, depth, motion, jitter, state):
            return self.model(Frame(color=color, depth=depth, motion=motion, jitter=jitter), state)

    exported = torch.export.export(Step(), (*inputs, state)).module()
    output, after = exported(*inputs, state)
    expected, expected_after = model(Frame.from_clip(buffers, 1), state)
    torch.testing.assert_close(output, expected)
    torch.testing.assert_close(after, expected_after)


class FixedWeights(NoReweighting):
    """Weights that a test sets, ``(B, previous, H, W)``."""

    def forward(self, current, past):
        return past * self.weights[:, :, None]


@pytest.mark.parametrize(("previous", "warp_at"), [(4, TargetResolution), (2, LowResolution)])
@torch.no_grad()
def test_reweighting_images_are_the_weights_of_the_output(previous, warp_at):
    """A network whose weights are those of the pictures, times 10, gives the same outputs."""
    upsample = ZeroUpsampling() if warp_at is TargetResolution else BilinearUpsampling()
    model = nsrr(2, previous, width=8, warp_at=warp_at(), upsample=upsample).double()
    for p in model.parameters():
        p.add_(torch.randn_like(p) * 0.05)
    fixed = nsrr(2, previous, width=8, warp_at=warp_at(), upsample=upsample, reweight=FixedWeights).double()
    fixed.load_state_dict(model.state_dict(), strict=False)
    buffers = clip(frames=4, dtype=torch.float64)
    state = None
    for t in range(4):
        frame = Frame.from_clip(buffers, t)
        images = model.pictured(frame, state)
        assert list(images) == [f"reweighting_{k + 1}" for k in range(previous)]
        fixed.previous_frames.reweight.weights = 10 * torch.cat(list(images.values()), dim=1)
        expected, _ = fixed(frame, state)
        output, state = model(frame, state)
        torch.testing.assert_close(output, expected, rtol=0, atol=1e-12)
    assert torch.cat(list(images.values())).std() > 0.001
    assert fixed.pictured(frame, state) == {}
    assert nsrr(2, 0).pictured(Frame.from_clip(clip(), 0), None) == {}
