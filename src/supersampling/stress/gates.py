"""Gates held open and shut: blending weights, accumulation, masks, the recurrent cell's, reweighting."""

from collections.abc import Callable
from functools import partial

import torch
from torch import Tensor, nn

from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS
from supersampling.models.enss import ENSS
from supersampling.models.nsrd import NSRD
from supersampling.models.nsrr import NSRR, PreviousFrames
from supersampling.models.tus import TUS
from supersampling.stages.history import Blended
from supersampling.stages.recur import Recurrent
from supersampling.stages.reweight import LearnedWeights
from supersampling.stress.extreme import Extreme

HELD = 1e4  # a bias that no other term of its sum reaches


def _part(bias: Tensor | None, first: int, last: int, value: float) -> None:
    assert bias is not None
    with torch.no_grad():
        bias[first:last] = value


def dlctus(model: Upsampler, first: int, value: float) -> bool:
    """``o1`` (``first`` 0) or ``o2`` (16) of every pixel far above 1 or below 0."""
    if not isinstance(model, DLCTUS):
        return False
    _part(model.network.output_layers()[-1].bias, first, first + 16, value)
    return True


def tus(model: Upsampler, alpha: float) -> bool:
    if not isinstance(model, TUS):
        return False
    model.alpha = alpha
    return True


def narrow(model: Upsampler, sigma: float) -> bool:
    """TUS's reconstruction kernel so narrow that every weight underflows, or as wide as the image."""
    if not isinstance(model, TUS):
        return False
    model.sigma = sigma
    return True


def enss(model: Upsampler, plane: int, value: float) -> bool:
    """The blending mask (plane 3) or the recurrent feature (plane 4)."""
    if not isinstance(model, ENSS) or not isinstance(model.history, Blended):
        return False
    block = model.scale**2
    _part(model.network.last_bias, plane * block, (plane + 1) * block, value)
    return True


def lstm(model: Upsampler, values: tuple[float, float, float]) -> bool:
    """NSRD's write, keep and show gates."""
    if not isinstance(model, NSRD) or not isinstance(model.recur, Recurrent):
        return False
    bias, width = model.recur.lstm.gates.bias, model.recur.width
    for k, value in enumerate(values):
        _part(bias, k * width, (k + 1) * width, value)
    return True


def gated(model: Upsampler, value: float) -> bool:
    """NSRD's gated convolution."""
    if not isinstance(model, NSRD):
        return False
    bias = model.gated.both.bias
    assert bias is not None
    _part(bias, bias.numel() // 2, bias.numel(), value)
    return True


def reweight(model: Upsampler, value: float) -> bool:
    """NSRR's weights of previous frames: 0, or the limit of 10."""
    if not isinstance(model, NSRR) or not isinstance(previous := model.previous_frames, PreviousFrames):
        return False
    if not isinstance(previous.reweight, LearnedWeights):
        return False
    last = previous.reweight.network[-2]
    assert isinstance(last, nn.Conv2d)
    _part(last.bias, 0, last.out_channels, value)
    return True


def _extreme(name: str, says: str, adjust: Callable[[Upsampler], bool]) -> Extreme:
    return Extreme(name, says, adjust=adjust, frames=12)


GATES = (
    _extreme("gate/o1 0", "DLCTUS: nothing of the input is blended in.", partial(dlctus, first=0, value=-HELD)),
    _extreme("gate/o1 1", "DLCTUS: nothing of the history is kept.", partial(dlctus, first=0, value=HELD)),
    _extreme("gate/accumulation 0", "DLCTUS: o2 is 0, the accumulation buffer is emptied.",
             partial(dlctus, first=16, value=-HELD)),
    _extreme("gate/accumulation 1", "DLCTUS: o2 is 1, the accumulation buffer never decays.",
             partial(dlctus, first=16, value=HELD)),
    _extreme("gate/alpha 0", "TUS: no sample is blended in.", partial(tus, alpha=0.0)),
    _extreme("gate/alpha 1", "TUS: a sample at a target pixel replaces it.", partial(tus, alpha=1.0)),
    _extreme("gate/sigma 1e-3", "TUS: a kernel whose every weight underflows.", partial(narrow, sigma=1e-3)),
    _extreme("gate/sigma 1e3", "TUS: a kernel as wide as the image.", partial(narrow, sigma=1e3)),
    _extreme("gate/mask 0", "ENSS: the candidate is not used.", partial(enss, plane=3, value=-HELD)),
    _extreme("gate/mask 1", "ENSS: the previous output is not used.", partial(enss, plane=3, value=HELD)),
    _extreme("gate/feature 1", "ENSS: the recurrent feature at its bound.", partial(enss, plane=4, value=HELD)),
    _extreme("gate/cell keeps all", "NSRD: the cell adds up and never forgets.", partial(lstm, values=(HELD, HELD, HELD))),
    _extreme("gate/cell keeps nothing", "NSRD: all gates of the cell are shut.", partial(lstm, values=(-HELD, -HELD, -HELD))),
    _extreme("gate/gated 0", "NSRD: the gated convolution is shut.", partial(gated, value=-HELD)),
    _extreme("gate/gated 1", "NSRD: the gated convolution is open.", partial(gated, value=HELD)),
    _extreme("reweight/0", "NSRR: previous frames have weight 0.", partial(reweight, value=-HELD)),
    _extreme("reweight/limit", "NSRR: previous frames have the largest weight, 10.", partial(reweight, value=HELD)),
)  # fmt: skip
