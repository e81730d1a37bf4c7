"""An image moved by whole pixels gives an output moved by as many, away from borders.

The low-resolution buffers are moved by 4 pixels and rolled round, at a scale of 2: by 8 target pixels. That is a
multiple of all that pools or works in blocks: DLCTUS's network (4 target pixels), NSRR's U-Net (4), ENSS's motion
blocks (8) and NSRD's U (4 low-resolution pixels). By other amounts these methods do not commute, and should not.
"""

import copy

import pytest
import torch
from model_cases import clip, every_variant, family_of, model_of
from torch import nn

from supersampling.frames import Frame
from supersampling.models.blocks.attention import UShaped

SHIFT = 4  # low-resolution pixels
# How far borders reach into the image in two frames, low-resolution pixels: radii of convolutions, a pixel of motion.
REACH = {"bicubic": 3, "jau": 2, "tus": 6, "tus_thesis": 6, "dlctus": 38, "enss_m": 14, "nsrr": 20, "nsrd": 11}
WIDEST = 40
# Numbers that change how much is computed and not how far it reaches.
NARROW = {"nsrr": ("model.width=4", "model.previous=2"), "enss_m": ("model.features=8",)}
ESTIMATED = {
    "model/flow=tvl1": "flow is estimated on a pyramid of the whole image",
    "model/flow=raft": "flow is estimated from correlations over the whole image",
}


def last(model, buffers):
    """The output of the second of two frames."""
    state = model.advance(Frame.from_clip(buffers, 0), None)
    return model(Frame.from_clip(buffers, 1), state)[0]


def moved(values):
    return values.roll((SHIFT, -SHIFT), (-2, -1)) if values.dim() == 5 else values


@every_variant
@torch.no_grad()
def test_translation_commutes_away_from_borders(variant):
    """NSRD is tested without its U-shaped module, whose channel attention takes means over the whole image: see
    below."""
    reasons = [reason for override, reason in ESTIMATED.items() if override in variant]
    if reasons:
        pytest.skip(reasons[0])
    family = family_of(variant[0])
    model = model_of(variant[0], *NARROW.get(family, ()), *variant[1:])
    if family == "nsrd":
        model = copy.deepcopy(model)
        model.reconstruct.body = nn.Identity()
    reach = REACH.get(family, WIDEST) + SHIFT
    size = 2 * (reach + 3)
    here = clip(model.requires, frames=2, b=1, h=size, w=size, motion=1.0 / size)
    there = {name: moved(values) for name, values in here.items()}
    expected, outputs = last(model, here), last(model, there)
    inner = (..., slice(2 * reach, -2 * reach), slice(2 * reach, -2 * reach))
    returned = outputs.roll((-2 * SHIFT, 2 * SHIFT), (-2, -1))
    torch.testing.assert_close(returned[inner], expected[inner], rtol=0, atol=1e-9)
    assert expected[inner].std() > 1e-3
    # At the border they differ, but for a method that looks at no neighbour.
    assert torch.allclose(returned, expected, atol=1e-6) == (family == "nearest")


@torch.no_grad()
def test_translation_of_the_u_shaped_module():
    """On a patch in the middle of nothing, and without biases, so that nothing stays nothing, borders play no part.

    A mean over the image is then what it was before the patch moved, so attention commutes too.
    """
    torch.manual_seed(0)
    module, size, side = UShaped(16).double(), 136, 8
    for name, p in module.named_parameters():
        if name.endswith("bias"):
            p.zero_()
    image = torch.zeros(1, 16, size, size, dtype=torch.float64)
    middle = slice(size // 2 - side // 2, size // 2 + side // 2)
    image[..., middle, middle] = torch.randn(1, 16, side, side, dtype=torch.float64)
    expected, outputs = module(image), module(image.roll((SHIFT, -SHIFT), (-2, -1)))
    torch.testing.assert_close(outputs.roll((-SHIFT, SHIFT), (-2, -1)), expected, rtol=0, atol=1e-12)
    assert expected[..., :4, :].abs().max() < 1e-12
    assert expected.std() > 1e-3
