"""DLCTUS as deployed (Swensen 2021, 4.4.4) against the plain form, which `test_dlctus` compares with the listing."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from torch.utils._python_dispatch import TorchDispatchMode

from supersampling.frames import Frame
from supersampling.models.dlctus_inference import DLCTUSForInference, DLCTUSWithoutShuffle, sparse_blocks
from supersampling.ops.resample import zero_upsample

CONF = Path(__file__).parents[2] / "conf"
SLOTS = ("reproject", "dilate", "pad", "accumulate", "confine", "initialise")
VARIANTS = [
    f"model/{slot}={option.stem}" for slot in SLOTS for option in sorted((CONF / "model" / slot).glob("*.yaml"))
]  # fmt: skip
FRAMES = 5


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    root = tmp_path_factory.mktemp("conf")
    (root / "root.yaml").write_text(
        f"defaults:\n  - model: dlctus\n  - _self_\ntask:\n  scale: 4\nhydra:\n  searchpath:\n    - file://{CONF}\n"
    )

    def make(scale, *overrides):
        with initialize_config_dir(str(root), version_base="1.3"):
            cfg = compose("root", [f"task.scale={scale}", *overrides])
        torch.manual_seed(0)
        return instantiate(cfg.model)

    return make


def clip(h, w, dtype, b=2):
    """Return frames of smooth motion, so that no position is within rounding of the image's border."""
    g = torch.Generator().manual_seed(1)
    y, x = torch.meshgrid(torch.arange(h), torch.arange(w), indexing="ij")
    frames = []
    for t in range(FRAMES):
        motion = torch.stack((0.07 * torch.sin(x + t), 0.09 * torch.cos(0.7 * y - t))).expand(b, -1, -1, -1)
        frames.append(
            Frame(
                color=torch.rand(b, 3, h, w, generator=g).to(dtype),
                depth=torch.rand(b, 1, h, w, generator=g).to(dtype),
                motion=motion.to(dtype),
                jitter=(torch.rand(b, 2, generator=g) - 0.5).to(dtype),
            )
        )
    return frames


@torch.no_grad()
def largest_difference(plain, frames, rewrite=DLCTUSForInference):
    """Return the largest difference of outputs and states over a clip, on which each form carries its own state."""
    deployed, difference = rewrite(plain), 0.0
    state = other_state = None
    for frame in frames:
        output, state = plain(frame, state)
        other_output, other_state = deployed(frame, other_state)
        assert other_output.shape == output.shape
        assert other_state.dtype == state.dtype
        difference = max(difference, (other_output - output).abs().max().item())
        difference = max(difference, (other_state - state).abs().max().item())
    assert output.std() > 0.05
    return difference


@pytest.mark.parametrize("rewrite", [DLCTUSWithoutShuffle, DLCTUSForInference])
@pytest.mark.parametrize("scale", [2, 3, 4, 5, 6])
@pytest.mark.parametrize(("h", "w"), [(6, 8), (5, 7), (1, 1), (4, 3)])
def test_equals_plain_form_at_every_scale_and_odd_sizes(build, scale, h, w, rewrite):
    plain = build(scale)
    assert largest_difference(plain, clip(h, w, torch.float32), rewrite) < 2e-5
    assert largest_difference(plain.double(), clip(h, w, torch.float64), rewrite) < 1e-12


@pytest.mark.parametrize("override", VARIANTS)
def test_equals_plain_form_with_every_stage(build, override):
    plain = build(4, override)
    assert largest_difference(plain, clip(5, 6, torch.float32)) < 2e-5
    assert largest_difference(plain.double(), clip(5, 6, torch.float64)) < 1e-12


@pytest.mark.parametrize("scale", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize(("h", "w"), [(4, 8), (3, 5)])
def test_sparse_samples_in_space_to_depth_order(scale, h, w):
    """Position by position, from the definition: channel, row of the block, column of the block, block."""
    torch.manual_seed(0)
    image, jitter = torch.rand(2, 3, h, w), torch.rand(2, 2) - 0.5
    blocks = sparse_blocks(image, jitter, scale)
    whole = zero_upsample(image, jitter, scale)
    height, width = h * scale, w * scale
    assert blocks.shape == (2, 3, 4, 4, -(-height // 4), -(-width // 4))
    for i in range(height):
        for j in range(width):
            assert torch.equal(blocks[:, :, i % 4, j % 4, i // 4, j // 4], whole[:, :, i, j])


def test_copy_is_independent_and_has_as_many_weights(build):
    plain = build(4)
    deployed = plain.for_inference()
    assert isinstance(deployed, DLCTUSForInference)
    frames = clip(4, 4, torch.float32)
    with torch.no_grad():
        before, _ = deployed(frames[0], None)
        second, _ = deployed(frames[1], before.new_ones(2, 4, 16, 16))
        for parameter in plain.parameters():
            parameter.zero_()
        after, _ = deployed(frames[1], before.new_ones(2, 4, 16, 16))
    assert torch.equal(second, after)
    assert sum(p.numel() for p in deployed.parameters()) == 78_112
    assert deployed.requires == plain.requires
    assert deployed.network.down.kernel_size == (1, 1)


class Calls(TorchDispatchMode):
    """A record of the called operations, with the size of a convolution's kernel."""

    def __init__(self):
        super().__init__()
        self.calls = set()

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        kernel = args[1].shape[2:] if func is torch.ops.aten.convolution.default else ()
        self.calls.add((func.overloadpacket.__name__, *kernel))
        return func(*args, **(kwargs or {}))


def test_operations_that_each_optimisation_removes(build):
    frame, *_ = clip(4, 4, torch.float32)
    plain, seen = build(4), {}
    forms = {"plain": plain, "1": DLCTUSWithoutShuffle(plain), "1 & 2": plain.for_inference()}
    for name, model in forms.items():
        with torch.no_grad(), Calls() as mode:
            model(frame, torch.rand(2, 4, 16, 16))
        seen[name] = {call for call in mode.calls if call[0] in ("convolution", "pixel_shuffle", "pixel_unshuffle")}
    assert seen["plain"] == {("convolution", 4, 4), ("convolution", 3, 3), ("pixel_shuffle",)}
    assert seen["1"] == {("convolution", 4, 4), ("convolution", 3, 3)}
    assert seen["1 & 2"] == {("convolution", 1, 1), ("convolution", 3, 3)}


@pytest.mark.parametrize("deployed", [False, True])
def test_history_stays_in_full_precision_under_autocast(build, deployed):
    model, frames = build(4), clip(4, 5, torch.float32)
    if deployed:
        model = model.for_inference()
    history = torch.rand(2, 4, 16, 20)
    with torch.no_grad():
        expected, _ = model(frames[0], history)
        with torch.autocast("cpu", torch.bfloat16):
            output, state = model(frames[0], history)
            model(frames[1], state)
    assert output.dtype == state.dtype == torch.float32
    torch.testing.assert_close(output, expected, rtol=0, atol=0.05)
    assert not torch.equal(output, expected)


def test_exports_to_a_graph(build):
    model = build(4).for_inference().eval()
    frame, *_ = clip(4, 4, torch.float32, b=1)
    state = torch.rand(1, 4, 16, 16)
    inputs = (frame.color, frame.depth, frame.motion, frame.jitter, state)

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, color, depth, motion, jitter, state):
            return self.model(Frame(color=color, depth=depth, motion=motion, jitter=jitter), state)

    with torch.no_grad():
        exported = torch.export.export(Step(), inputs).module()
        for actual, expected in zip(exported(*inputs), model(frame, state), strict=True):
            torch.testing.assert_close(actual, expected)
