import math

import pytest
import torch
import torch.nn.functional as F

from supersampling.stages.recur import ConvLSTM, NotRecurrent, Recurrent


def numbers(*shape):
    return torch.randn(*shape, dtype=torch.float64)


def sigmoid(x):
    return 1.0 / (1.0 + math.exp(-x))


def test_convlstm_is_its_equations():
    torch.manual_seed(0)
    lstm = ConvLSTM(3, 2).double()
    x, hidden, cell = numbers(2, 3, 4, 5), numbers(2, 2, 4, 5), numbers(2, 2, 4, 5)
    with torch.no_grad():
        actual_hidden, actual_cell = lstm(x, hidden, cell)
        gates = F.conv2d(torch.cat((x, hidden), 1), lstm.gates.weight, lstm.gates.bias, padding=1)
    for n in range(2):
        for c in range(2):
            for i in range(4):
                for j in range(5):
                    write, keep, show, value = (gates[n, 2 * k + c, i, j].item() for k in range(4))
                    new = sigmoid(keep) * cell[n, c, i, j].item() + sigmoid(write) * math.tanh(value)
                    assert actual_cell[n, c, i, j].item() == pytest.approx(new, abs=1e-12)
                    shown = sigmoid(show) * math.tanh(new)
                    assert actual_hidden[n, c, i, j].item() == pytest.approx(shown, abs=1e-12)


def stage(cls):
    torch.manual_seed(0)
    return cls(channels=3, width=2, scale=2).double()


def test_the_previous_output_arrives_warped_and_in_low_resolution_channels():
    recur, inputs = stage(Recurrent), []
    recur.first.register_forward_hook(lambda module, args, out: inputs.append(args[0]))
    output = numbers(1, 3, 8, 12)
    motion = torch.zeros(1, 2, 8, 12, dtype=torch.float64)
    motion[:, 0] = 4 / 12
    recur(numbers(1, 3, 4, 6), motion, (output, numbers(1, 2, 4, 6), numbers(1, 2, 4, 6)))
    for channel in range(3):
        for i in range(8):
            for j in range(8):
                place = 4 * channel + 2 * (i % 2) + j % 2
                actual = inputs[0][0, place, i // 2, j // 2]
                torch.testing.assert_close(actual, output[0, channel, i, j + 4])


def test_a_clip_begins_with_zeros():
    recur, shallow = stage(Recurrent), numbers(2, 3, 4, 6)
    still = torch.zeros(2, 2, 8, 12, dtype=torch.float64)
    zeros = tuple(torch.zeros(2, c, *s, dtype=torch.float64) for c, s in ((3, (8, 12)), (2, (4, 6)), (2, (4, 6))))
    begun, explicit = recur(shallow, still, ()), recur(shallow, still, zeros)
    assert torch.equal(begun[0], explicit[0])
    output = numbers(2, 3, 8, 12)
    carried = recur.carry(output, begun[1])
    assert [tuple(c.shape) for c in carried] == [(2, 3, 8, 12), (2, 2, 4, 6), (2, 2, 4, 6)]
    assert carried[0] is output


def test_gradients_of_the_step():
    recur = stage(Recurrent)
    motion = numbers(1, 2, 4, 6) * 0.05
    leaves = [numbers(1, 3, 2, 3), numbers(1, 3, 4, 6), numbers(1, 2, 2, 3), numbers(1, 2, 2, 3)]
    for leaf in leaves:
        leaf.requires_grad_()

    def step(shallow, *carried):
        features, memory = recur(shallow, motion, carried)
        return features, *memory

    assert torch.autograd.gradcheck(step, leaves)


def test_none_keeps_nothing_and_has_no_lstm_weights():
    recur, shallow = stage(NotRecurrent), numbers(1, 3, 4, 6)
    features, memory = recur(shallow, torch.zeros(1, 2, 8, 12), ())
    expected = F.conv2d(shallow, recur.first.weight, recur.first.bias, padding=1).clamp_min(0.0)
    torch.testing.assert_close(features, expected)
    assert recur.carry(numbers(1, 3, 8, 12), memory) == ()
    assert sum(p.numel() for p in recur.parameters()) == 3 * 2 * 9 + 2


def test_the_cell_keeps_its_precision_under_autocast():
    recur = Recurrent(channels=3, width=2, scale=2)
    with torch.autocast("cpu", torch.bfloat16):
        _, (hidden, cell) = recur(torch.rand(1, 3, 4, 6).bfloat16(), torch.zeros(1, 2, 8, 12), ())
    assert hidden.dtype == cell.dtype == torch.float32


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("part", range(3))
def test_values_that_are_not_finite_are_not_carried(value, part):
    """In output, hidden state or cell, values that are not finite count as 0."""
    stage = Recurrent(channels=4, width=3, scale=2).double()
    shallow, motion = numbers(1, 4, 3, 5), torch.zeros(1, 2, 6, 10, dtype=torch.float64)
    carried = [numbers(1, 3, 6, 10), numbers(1, 3, 3, 5), numbers(1, 3, 3, 5)]
    spoiled, zeroed = [t.clone() for t in carried], [t.clone() for t in carried]
    spoiled[part][0, 1, 2, 3], zeroed[part][0, 1, 2, 3] = value, 0.0
    actual, expected = (stage(shallow, motion, tuple(c)) for c in (spoiled, zeroed))
    assert torch.equal(actual[0], expected[0])
    assert torch.equal(actual[1][1], expected[1][1])
