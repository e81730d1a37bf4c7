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


def test_a_history_that_is_not_finite_is_replaced_and_its_gradient_with_it():
    history, aligned = torch.rand(1, 4, 6, 8), torch.rand(1, 4, 6, 8)
    history[0, 1, 2, 3], history[0, 3, 4, 5] = torch.nan, torch.inf
    history.requires_grad_()
    for stage, replaced in ((JitterAligned(), aligned), (Zeros(), torch.zeros_like(aligned))):
        padded = stage(history, aligned, torch.zeros(1, 2, 6, 8))
        for i, j in ((2, 3), (4, 5)):
            assert torch.equal(padded[..., i, j], replaced[..., i, j])
        assert int((padded == history).all(dim=1).sum()) == 46
        (gradient,) = torch.autograd.grad(padded.sum(), history)
        assert gradient.sum() == 46 * 4
