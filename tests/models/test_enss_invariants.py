"""ENSS: properties that hold for any weights, and deployment."""

from functools import partial

import pytest
import torch
import torch.nn.functional as F
from enss_cases import SMALL, clip, enss, run

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.stages.flow import JitteredMotionVectors
from supersampling.stages.history import Unblended
from supersampling.stages.kernel_prediction import FirstAndLast, FirstOnly, LastOnly
from supersampling.stages.motion_grid import BilinearMotion, FrontmostOfBlock


@pytest.mark.parametrize("grid", [FrontmostOfBlock(8), BilinearMotion()])
def test_zero_motion_keeps_the_history_bit_for_bit(grid):
    model, buffers = enss(3, motion_grid=grid), clip(motion=0.0)
    inputs_of_network, state = [], run(model, {k: v[:, :1] for k, v in buffers.items()})[1]
    model.network.register_forward_pre_hook(lambda _, inputs: inputs_of_network.append(inputs[0]))
    model(Frame.from_clip(buffers, 1), state)
    assert torch.equal(inputs_of_network[0][:, 6:], F.pixel_unshuffle(state[0], 3))


@pytest.mark.parametrize("stages", [{}, {"history": Unblended()}, {"motion_grid": BilinearMotion()}])
def test_a_shift_by_whole_blocks_commutes_away_from_borders(stages):
    """8 target pixels are 4 low-resolution ones at a scale of 2; borders reach 3 pixels + motion further per frame."""
    model = enss(2, **stages).double()
    wide = clip(frames=2, b=1, h=40, w=44, motion=0.0, dtype=torch.float64)
    wide["motion"] = wide["motion"] + torch.tensor([1.0 / 80, -1.0 / 80], dtype=torch.float64).view(2, 1, 1)
    narrow = {k: v[..., 8:, 4:] if v.dim() == 5 else v for k, v in wide.items()}
    scale = torch.tensor([44 / 40, 40 / 32], dtype=torch.float64).view(2, 1, 1)  # motion is in units of the image
    narrow["motion"] = narrow["motion"] * scale
    with torch.no_grad():
        whole, part = run(model, wide)[0][..., 16:, 8:], run(model, narrow)[0]
    inner = (..., slice(24, -24), slice(24, -24))
    torch.testing.assert_close(part[inner], whole[inner], rtol=0, atol=1e-9)
    assert not torch.allclose(part, whole, atol=1e-3)  # at the border they differ


def test_jitter_in_the_motion_vectors_is_compensated_by_its_stage():
    buffers = clip(frames=4, motion=0.05)
    difference = buffers["jitter"].diff(dim=1) / torch.tensor([6.0, 5.0])
    jittered = buffers["motion"].clone()
    jittered[:, 1:] += difference[..., None, None]
    with torch.no_grad():
        expected, _ = run(enss(), buffers)
        outputs, _ = run(enss(flow=JitteredMotionVectors()), buffers | {"motion": jittered})
    torch.testing.assert_close(outputs, expected, rtol=0, atol=1e-5)


# Deployment


@pytest.mark.parametrize("kernels", [FirstAndLast, FirstOnly, LastOnly])
def test_precomputed_kernels_give_the_same_output(kernels):
    model = enss(kernel_prediction=partial(kernels, **SMALL)).double()
    buffers = clip(frames=8, dtype=torch.float64)
    sequence = torch.rand(16, 2, dtype=torch.float64) - 0.5
    buffers["jitter"] = sequence[torch.stack((torch.arange(8), torch.arange(5, 13)))]
    with torch.no_grad():
        model.network.kernels.mlp.layers[-1].weight.normal_(0.0, 0.2)  # so that the jitter matters
    trained = sum(p.numel() for p in model.parameters())
    deployed = model.with_precomputed_kernels(sequence)
    with torch.no_grad():
        expected, outputs = run(model, buffers)[0], run(deployed, buffers)[0]
        mismatched = run(model.with_precomputed_kernels(sequence.flip(1)), buffers)[0]
    torch.testing.assert_close(outputs, expected, rtol=0, atol=1e-12)
    assert (mismatched - expected).abs().max() > 1e-3
    assert sum(p.numel() for p in model.parameters()) == trained
    assert not any("mlp" in name for name, _ in deployed.named_parameters())


@pytest.mark.parametrize("deployed", [False, True])
def test_exports_to_a_graph_for_any_batch_size(deployed):
    model = enss().eval()
    if deployed:
        model = model.with_precomputed_kernels(torch.rand(16, 2) - 0.5)
    names = ("color", "depth", "motion", "jitter")

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, color, depth, motion, jitter, history):
            frame = Frame(color=color, depth=depth, motion=motion, jitter=jitter)
            output, (history,) = self.model(frame, (history,))
            return output, history

    def inputs(b):
        return (*(clip(b=b)[name][:, 1] for name in names), torch.rand(b, 4, 10, 12))

    batch = {0: torch.export.Dim("batch", min=2)}
    with torch.no_grad():
        exported = torch.export.export(Step(), inputs(2), dynamic_shapes=(batch,) * 5).module()
        for b in (2, 5):
            values = inputs(b)
            for actual, expected in zip(exported(*values), Step()(*values)):
                torch.testing.assert_close(actual, expected, rtol=0, atol=1e-5)


def test_runs_under_autocast_with_a_history_in_full_precision():
    model, buffers = enss(), clip()
    with torch.no_grad():
        expected, _ = run(model, buffers)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            outputs, state = run(model, buffers)
    assert outputs.dtype == state[0].dtype == torch.float32
    assert (outputs - expected).abs().max() < 0.05


@pytest.mark.parametrize(("features", "depth"), [(0, 1), (8, -1)])
def test_invalid_size_raises(features, depth):
    with pytest.raises(UserError, match=rf"Invalid model\.features={features} with model\.depth={depth}: use"):
        enss(features=features, depth=depth)


@pytest.mark.parametrize("value", [torch.nan, torch.inf])
def test_a_history_that_is_not_finite_counts_as_zero(value):
    model, buffers = enss(2), clip()
    state = run(model, {k: v[:, :1] for k, v in buffers.items()})[1]
    states = [(state[0].clone(), *state[1:]) for _ in range(2)]
    states[0][0][:] = value
    states[1][0].zero_()
    (got, after), (expected, _) = (model(Frame.from_clip(buffers, 1), s) for s in states)
    assert got.isfinite().all()
    assert after[0].isfinite().all()
    assert torch.equal(got, expected)
