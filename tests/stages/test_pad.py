import torch

from supersampling.stages.pad import JitterAligned, Zeros


def test_only_pixels_from_outside_the_image_are_replaced():
    history, aligned = torch.rand(1, 4, 6, 8), torch.rand(1, 4, 6, 8)
    motion = torch.zeros(1, 2, 6, 8)
    motion[:, 0] = -2.0 / 8  # the two leftmost columns come from outside
    for stage, replaced in ((JitterAligned(), aligned), (Zeros(), torch.zeros_like(aligned))):
        padded = stage(history, aligned, motion)
        assert torch.equal(padded[..., :2], replaced[..., :2])
        assert torch.equal(padded[..., 2:], history[..., 2:])
