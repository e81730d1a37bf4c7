"""LPIPS by its authors' package ``lpips`` (Zhang et al. 2018), version 0.1 of its weights."""

import math
import warnings
from collections import OrderedDict
from functools import cache
from typing import final

import torch
from torch import nn

from supersampling.errors import UserError
from supersampling.metrics.base import FrameMetric, Moment

# By the package's name: torchvision's name, and the smallest image side for which every layer has an output.
NETWORKS = {"alex": ("alexnet", 31), "vgg": ("vgg16", 16)}


@cache
def trained(network: str) -> nn.Module:
    """Return the package's module, frozen. Its learned weights come with the package, its classifier is torchvision's.

    Raises:
        UserError: the classifier's weights are not available; the message names the file and its folder.
    """
    # Imported here because both load torchvision, which takes seconds and is not needed to know the metric's direction.
    import lpips

    from supersampling.pretrained import load_pretrained

    with warnings.catch_warnings():
        # The package passes deprecated arguments to torchvision.
        warnings.simplefilter("ignore")
        module: nn.Module = lpips.LPIPS(net=network, pnet_rand=True, verbose=False)
    # The package splits torchvision's layers into slices and keeps their names.
    slices = module.get_submodule("net").children()
    layers = OrderedDict(pair for part in slices for pair in part.named_children())
    name, _ = NETWORKS[network]
    load_pretrained(nn.Sequential(layers), name, "IMAGENET1K_V1", "LPIPS", "leave the metric out", prefix="features.")
    return module.requires_grad_(False).eval()


@final
class LPIPS(FrameMetric):
    """``lpips_alex`` or ``lpips_vgg``: distance of two images in the features of a classifier, 0 for identical images.

    The mean over whole frames in [0, 1], which are not scaled down.

    Args:
        network: ``alex``, the package's default, or ``vgg``, its recommendation for a loss; a paper that does not name
            its network most likely used the first. The two are different metrics.
    """

    better = {"lpips_*": "lower"}

    def __init__(self, network: str) -> None:
        if network not in NETWORKS:
            raise UserError(f"Unknown network={network} of LPIPS: use {' or '.join(NETWORKS)}.")
        self.names = (f"lpips_{network}",)
        self._module, self._smallest = trained(network), NETWORKS[network][1]

    @torch.no_grad()
    def measure(self, moment: Moment) -> list[float]:
        height, width = moment.output.shape[-2:]
        if min(height, width) < self._smallest:
            raise UserError(
                f"Images of {width}x{height} pixels are too small for {self.names[0]}: use at least "
                f"{self._smallest}x{self._smallest}."
            )
        # No half precision under autocast: near the target, the difference of the features is below its rounding.
        with torch.autocast(moment.output.device.type, enabled=False):
            distance = self._module.to(moment.output.device)(
                moment.output.float(), moment.target.float(), normalize=True
            )
        return [distance.item()]


@final
class Untrained(FrameMetric):
    """Substitute for `LPIPS` if the weights of its classifier are not available: no value."""

    better = LPIPS.better

    def __init__(self, network: str) -> None:
        self.names = (f"lpips_{network}",)

    def measure(self, moment: Moment) -> list[float]:
        return [math.nan]


@cache
def where_trained(network: str) -> FrameMetric:
    """Return `LPIPS` if its weights are on disk or can be downloaded, else print the reason and return `Untrained`.

    Cached per process: every job and baseline composes the same metrics, and waiting for an unreachable hub takes long.
    """
    try:
        return LPIPS(network)
    except UserError as error:
        print(f"lpips_{network} is left out: {error}", flush=True)
        return Untrained(network)
