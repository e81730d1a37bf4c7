"""LPIPS by its authors' own package, ``lpips`` (Zhang et al. 2018), version 0.1 of its weights."""

import warnings
from collections import OrderedDict
from functools import cache
from typing import final

import lpips
import torch
from torch import nn

from supersampling.errors import UserError
from supersampling.metrics.suite import Metric, Moment
from supersampling.pretrained import load_pretrained

# The package's name: torchvision's, and the smallest side that every layer has an output for.
NETWORKS = {"alex": ("alexnet", 31), "vgg": ("vgg16", 16)}


@cache
def trained(network: str) -> nn.Module:
    """The package's module, frozen. What it learned is in the package; the classifier under it is torchvision's.

    Raises:
        UserError: the classifier's weights cannot be had; it says which file goes where.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it calls torchvision by arguments that are deprecated
        module: nn.Module = lpips.LPIPS(net=network, pnet_rand=True, verbose=False)
    # The package cuts torchvision's layers into slices and keeps their names.
    slices = module.get_submodule("net").children()
    layers = OrderedDict(pair for part in slices for pair in part.named_children())
    name, _ = NETWORKS[network]
    load_pretrained(nn.Sequential(layers), name, "IMAGENET1K_V1", "LPIPS", "leave the metric out", prefix="features.")
    return module.requires_grad_(False).eval()


@final
class LPIPS(Metric):
    """``lpips_alex`` or ``lpips_vgg``: a distance between two images in a classifier's features, 0 for identical ones.

    On whole frames in [0, 1], not scaled down; the mean over the frame.

    Args:
        network: ``alex``, the package's own choice, or ``vgg``, its choice for a loss; a paper that does not say which is most
            likely the first. The two are different metrics.
    """

    requires = frozenset({"target"})

    def __init__(self, network: str) -> None:
        if network not in NETWORKS:
            raise UserError(f"network={network} of LPIPS: use {' or '.join(NETWORKS)}.")
        self.names = (f"lpips_{network}",)
        self._module, self._least = trained(network), NETWORKS[network][1]

    @torch.no_grad()
    def __call__(self, moment: Moment) -> dict[str, float]:
        height, width = moment.output.shape[-2:]
        if min(height, width) < self._least:
            raise UserError(
                f"{self.names[0]} needs images of at least {self._least}x{self._least} pixels, got {width}x{height}; use "
                "larger ones."
            )
        # Not in half precision under autocast: near the target, the features' difference is below its rounding.
        with torch.autocast(moment.output.device.type, enabled=False):
            distance = self._module.to(moment.output.device)(
                moment.output.float(), moment.target.float(), normalize=True
            )
        return {self.names[0]: distance.item()}


@final
class Untrained(Metric):
    """In the place of `LPIPS` where its classifier's weights cannot be had: no value."""

    requires = frozenset({"target"})

    def __init__(self, network: str) -> None:
        self.names = (f"lpips_{network}",)

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {self.names[0]: float("nan")}


@cache
def where_trained(network: str) -> Metric:
    """`LPIPS` if its weights are there or can be fetched, else `Untrained`, with the reason printed.

    Asked once a process: every job and baseline composes the same metrics, and a hub that does not answer takes its time.
    """
    try:
        return LPIPS(network)
    except UserError as error:
        print(f"lpips_{network} is left out: {error}", flush=True)
        return Untrained(network)
