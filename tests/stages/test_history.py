import math

import pytest
import torch

from supersampling.stages.history import Blended, NoHistory, Unblended


def test_blending_is_equation_3():
    candidate, extra, previous = torch.rand(2, 3, 4, 5), torch.randn(2, 2, 4, 5) * 3, torch.rand(2, 4, 4, 5)
    output, history = Blended()(candidate, extra, previous)
    for n in range(2):
        for c in range(3):
            for i in range(4):
                for j in range(5):
                    alpha = 1.0 / (1.0 + math.exp(-extra[n, 0, i, j].item()))
                    expected = alpha * candidate[n, c, i, j] + (1.0 - alpha) * previous[n, c, i, j]
                    assert output[n, c, i, j].item() == pytest.approx(expected.item(), abs=1e-6)
    assert torch.equal(history, torch.cat((output, extra[:, 1:].tanh()), dim=1))


@pytest.mark.parametrize(("mask", "keeps"), [(-200.0, True), (200.0, False)])
def test_the_mask_at_its_ends_keeps_or_discards_the_previous_output(mask, keeps):
    candidate, previous = torch.rand(1, 3, 4, 5), torch.rand(1, 4, 4, 5)
    output, _ = Blended()(candidate, torch.full((1, 2, 4, 5), mask), previous)
    assert torch.equal(output, previous[:, :3] if keeps else candidate)


def test_gradient_of_blending():
    sizes = (3, 2, 4)
    tensors = [torch.rand(1, c, 2, 3, dtype=torch.float64, requires_grad=True) for c in sizes]
    assert torch.autograd.gradcheck(Blended(), tensors)


def test_rounding_of_the_previous_output_does_not_leave_the_range():
    high = torch.full((1, 4, 2, 2), 1.0 + 2**-22)
    output, _ = Blended()(torch.ones(1, 3, 2, 2), torch.zeros(1, 2, 2, 2), high)
    assert output.max() == 1.0


def test_without_blending_the_candidate_is_the_output():
    candidate, extra = torch.rand(1, 3, 4, 5), torch.randn(1, 1, 4, 5)
    output, history = Unblended()(candidate, extra, torch.rand(1, 4, 4, 5))
    assert torch.equal(output, candidate)
    assert torch.equal(history, torch.cat((candidate, extra.tanh()), dim=1))


def test_without_history_nothing_is_carried():
    candidate = torch.rand(1, 3, 4, 5)
    output, history = NoHistory()(candidate, torch.rand(1, 0, 4, 5), None)
    assert torch.equal(output, candidate)
    assert history.shape == (1, 0, 4, 5)


@pytest.mark.parametrize("stage", [Blended(), Unblended()])
def test_history_starts_with_colour_and_features_of_zero(stage):
    color = torch.rand(2, 3, 4, 5)
    assert torch.equal(stage.start(color), torch.cat((color, torch.zeros(2, 1, 4, 5)), dim=1))
