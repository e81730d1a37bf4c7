import torch

from supersampling.stages.accumulate import AccumulationBuffer, NoAccumulation


def test_the_buffer_starts_at_one_and_is_scaled_by_o2_alone():
    color, keep = torch.rand(2, 3, 4, 5), torch.rand(2, 1, 4, 5)
    stage = AccumulationBuffer()
    history = stage.append(color)
    assert history.shape[1] == stage.channels
    assert torch.equal(history[:, :3], color)
    assert (history[:, 3] == 1.0).all()
    updated = stage(history, keep)
    assert torch.equal(updated[:, :3], color)
    assert torch.equal(updated[:, 3:], keep)


def test_without_it_history_is_colour():
    color = torch.rand(2, 3, 4, 5)
    stage = NoAccumulation()
    assert stage.channels == 3
    assert torch.equal(stage(stage.append(color), torch.zeros(2, 1, 4, 5)), color)


def test_the_buffer_alone_is_worth_looking_at():
    history = torch.rand(2, 4, 3, 5)
    pictured = AccumulationBuffer().pictured(history)
    assert list(pictured) == ["accumulation"]
    assert torch.equal(pictured["accumulation"], history[:, 3].unsqueeze(1))
    assert NoAccumulation().pictured(history[:, :3]) == {}
