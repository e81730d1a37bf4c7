"""Optimizers that treat groups of parameters differently."""

from collections.abc import Iterable

from pytorch_optimizer import Muon
from torch import nn
from torch.optim import Optimizer


def muon(parameters: Iterable[nn.Parameter], lr: float, momentum: float = 0.9) -> Optimizer:
    """Return Muon for weights and Adam for biases and other vectors, at one learning rate.

    A convolution's weight counts as the matrix (outputs, inputs x taps). Its step is as long as Adam's would be
    (Liu et al. 2025, "Muon is scalable for LLM training", 2.2), equally along all singular directions: history
    and input are correlated colours, whose differences Adam learns slowly.
    """
    trained = list(parameters)
    matrices = {"params": [p for p in trained if p.ndim >= 2], "use_muon": True}
    vectors = {"params": [p for p in trained if p.ndim < 2], "use_muon": False}
    groups = [group for group in (matrices, vectors) if group["params"]]
    return Muon(groups, lr=lr, momentum=momentum, adamw_lr=lr, adamw_betas=(0.9, 0.99), use_adjusted_lr=True)
