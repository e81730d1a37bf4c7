import torch

from supersampling.stages.accumulate import AccumulationBuffer, NoAccumulation


def test_buffer_starts_at_one_and_is_scaled_by_o2_only():
    color, keep = torch.rand(2, 3, 4, 5), torch.rand(2, 1, 4, 5)
    stage = AccumulationBuffer()
    history = stage.append(color)
    assert history.shape[1] == stage.channels
    assert torch.equal(history[:, :3], color)
    assert (history[:, 3] == 1.0).all()
    updated = stage(history, keep)
    assert torch.equal(updated[:, :3], color)
    assert torch.equal(updated[:, 3:], keep)


def test_without_buffer_history_is_colour():
    color = torch.rand(2, 3, 4, 5)
    stage = NoAccumulation()
    assert stage.channels == 3
    assert torch.equal(stage(stage.append(color), torch.zeros(2, 1, 4, 5)), color)


def test_state_images_are_the_buffer():
    history = torch.rand(2, 4, 3, 5)
    images = AccumulationBuffer().state_images(history)
    assert list(images) == ["accumulation"]
    assert torch.equal(images["accumulation"], history[:, 3].unsqueeze(1))
    assert NoAccumulation().state_images(history[:, :3]) == {}
