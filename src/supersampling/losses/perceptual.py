"""Distance between the features of a pretrained image classifier."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor
from torchvision.models.vgg import cfgs, make_layers

from supersampling.errors import UserError
from supersampling.losses.base import Loss
from supersampling.pretrained import load_pretrained

# VGG-16's convolutions by block (Simonyan and Zisserman 2015, configuration D); all blocks but the first start with a
# max-pool.
_BLOCKS = (2, 2, 3, 3, 3)
LAYERS = tuple(f"relu{b}_{k}" for b, n in enumerate(_BLOCKS, 1) for k in range(1, n + 1))


@dataclass(frozen=True)
class Pretrained:
    """``(weight, bias)`` of the 13 convolutions in order, and the mean and deviation that normalise inputs."""

    convolutions: tuple[tuple[Tensor, Tensor], ...]
    mean: tuple[float, ...]
    deviation: tuple[float, ...]


@cache
def pretrained(weights: str) -> Pretrained:
    """Load VGG-16 through torchvision, which downloads it once.

    Raises:
        UserError: the weights do not exist or cannot be loaded; the message says which file to put where.
    """
    layers = make_layers(cfgs["D"])
    entry = load_pretrained(layers, "vgg16", weights, "The perceptual loss", "remove the term", prefix="features.")
    convolutions = [m for m in layers if isinstance(m, torch.nn.Conv2d)]
    pairs = tuple((m.weight.detach(), m.bias.detach()) for m in convolutions if m.bias is not None)
    preset = entry.transforms()
    return Pretrained(pairs, tuple(preset.mean), tuple(preset.std))


@final
class Perceptual(Loss):
    """Perceptual term of Xiao et al. 2020, eq 1: ``sum over layers of |conv_i(x) - conv_i(y)|^2`` in VGG-16.

    The paper sums five layers and refers to Johnson et al. 2016 for their names; that paper names four, relu1_2,
    relu2_2, relu3_3 and relu4_3: the last of each block. The fifth is assumed to be relu5_3, the last of the fifth
    block. Each square is a mean over the layer's values, as in Johnson et al., equation 2 (a plain sum, as equation 1
    may be read, would make the SSIM term negligible). Images are treated as RGB in [0, 1] and normalised as the weights
    require; values of other domains are used unchanged (the paper, too, feeds YCbCr when its output is YCbCr).

    Args:
        layers: names from `LAYERS`, at least one.
        weights: a name in ``torchvision.models.VGG16_Weights``.
    """

    requires = frozenset[str]()
    previous = 0
    mean: Tensor
    deviation: Tensor

    def __init__(self, layers: Sequence[str], weights: str) -> None:
        super().__init__()
        unknown = [name for name in layers if name not in LAYERS]
        if unknown or not layers:
            raise UserError(f"Invalid layers={list(layers)} of the perceptual loss: use some of {', '.join(LAYERS)}.")
        network = pretrained(weights)
        self.layers = frozenset(layers)
        self._run = LAYERS[: max(LAYERS.index(name) for name in layers) + 1]
        # Non-persistent buffers follow the device and stay out of checkpoints and optimizers.
        self.register_buffer("mean", torch.tensor(network.mean)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(network.deviation)[:, None, None], persistent=False)
        for name, (kernel, bias) in zip(self._run, network.convolutions):
            self.register_buffer(f"{name}_kernel", kernel, persistent=False)
            self.register_buffer(f"{name}_bias", bias, persistent=False)

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        height, width = outputs.shape[-2:]
        smallest = 2 ** (int(self._run[-1][4]) - 1)
        if min(height, width) < smallest:
            raise UserError(
                f"Crops of {width}x{height} pixels are too small for layer {self._run[-1]} of VGG-16: "
                f"set budget.crop to at least {smallest}, or remove the layer."
            )
        # Use float32 under autocast: half precision would round away the features' difference near the target.
        with torch.autocast(outputs.device.type, enabled=False):
            with torch.no_grad():
                target_features = self.features(targets.flatten(0, 1).float())
            output_features = self.features(outputs.flatten(0, 1).float())
            return torch.stack([F.mse_loss(a, b) for a, b in zip(output_features, target_features)]).sum()

    def features(self, images: Tensor) -> list[Tensor]:
        """Return the selected layers' activations of images ``(B, 3, H, W)``, in the network's order."""
        x = (images - self.mean) / self.deviation
        activations = []
        for name in self._run:
            if name.endswith("_1") and name != LAYERS[0]:
                x = F.max_pool2d(x, 2)
            x = F.relu(F.conv2d(x, getattr(self, f"{name}_kernel"), getattr(self, f"{name}_bias"), padding=1))
            if name in self.layers:
                activations.append(x)
        return activations
