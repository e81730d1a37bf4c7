"""A second implementation of Xiao et al. 2020, section 3.2, without a state, and the helpers of its tests."""

import torch
import torch.nn.functional as F

from supersampling.frames import Frame
from supersampling.models.nsrr import NSRR
from supersampling.stages.base import NoBase
from supersampling.stages.colour_space import YCbCr
from supersampling.stages.demodulate import DisplayColour
from supersampling.stages.extract import LearnedFeatures
from supersampling.stages.guides import NoGuides
from supersampling.stages.reweight import LearnedWeights
from supersampling.stages.upsample import ZeroUpsampling
from supersampling.stages.warp_at import TargetResolution


def nsrr(scale=4, previous=4, width=64, extract=LearnedFeatures, upsample=None, warp_at=None, reweight=LearnedWeights,
         colour_space=None, demodulate=None, guides=None, base=None):  # fmt: skip
    torch.manual_seed(0)
    return NSRR(
        scale,
        previous,
        width,
        extract,
        upsample or ZeroUpsampling(),
        warp_at or TargetResolution(),
        reweight,
        colour_space or YCbCr(),
        demodulate or DisplayColour(),
        guides or NoGuides(),
        base or NoBase(),
    )


def clip(frames=3, b=2, h=5, w=6, motion=0.1, jitter=1.0, seed=0, dtype=torch.float32):
    g = torch.Generator().manual_seed(seed)

    def rand(*shape):
        return torch.rand(b, frames, *shape, generator=g, dtype=dtype)

    return {
        "color": rand(3, h, w),
        "depth": rand(1, h, w),
        "motion": (rand(2, h, w) - 0.5) * 2 * motion,
        "jitter": (rand(2) - 0.5) * jitter,
    }


def run(model, buffers):
    outputs, state = [], None
    for t in range(buffers["depth"].shape[1]):
        output, state = model(Frame.from_clip(buffers, t), state)
        outputs.append(output)
    return torch.stack(outputs, dim=1), state


def spread(image, jitter, scale):
    out = image.new_zeros(*image.shape[:2], image.shape[2] * scale, image.shape[3] * scale)
    for n in range(len(image)):
        x, y = (int(v) for v in torch.floor((jitter[n] + 0.5) * scale))
        out[n, :, y::scale, x::scale] = image[n]
    return out


def back(image, motion):
    """Warp once as in 3.2.2, with zeros exactly outside the image instead of the library's, which fade over a pixel."""
    height, width = image.shape[2:]
    motion = F.interpolate(motion, size=(height, width), mode="bilinear", align_corners=False)
    x = (torch.arange(width, dtype=image.dtype) + 0.5) / width + motion[:, 0]
    y = (torch.arange(height, dtype=image.dtype)[:, None] + 0.5) / height + motion[:, 1]
    grid = torch.stack((x, y), -1) * 2 - 1
    inside = ((x >= 0) & (x <= 1) & (y >= 0) & (y <= 1))[:, None]
    return F.grid_sample(image, grid, padding_mode="border", align_corners=False) * inside


def transcribed(model, buffers, t, n, scale, guides=()):
    """Return the output of frame ``t`` from its window (figure 4, left to right); ``guides`` names more inputs."""

    def conv(x, layer):
        return F.conv2d(x, layer.weight, layer.bias, padding=1)

    def features(samples, network):
        x = samples
        for k in (0, 2, 4):
            x = torch.relu(conv(x, network[k]))
        return torch.cat((samples, x), 1)

    def samples(k):
        r, g, b = buffers["color"][:, k].unbind(1)
        y = 0.299 * r + 0.587 * g + 0.114 * b
        ycbcr = torch.stack((y, 0.5 + (b - y) * 0.5 / (1 - 0.114), 0.5 + (r - y) * 0.5 / (1 - 0.299)), 1)
        return torch.cat((ycbcr, *(buffers[name][:, k] for name in ("depth", *guides))), 1)

    current = spread(features(samples(t), model.extract.network), buffers["jitter"][:, t], scale)
    past = []
    for k in range(t - 1, t - 1 - n, -1):
        start = max(k, 0)  # the first frame stands in for those before it, without motion
        image = spread(
            features(samples(start), model.previous_frames.extract.network), buffers["jitter"][:, start], scale
        )
        for m in range(start + 1, t + 1):
            image = back(image, buffers["motion"][:, m])
        past.append(image)

    x = torch.cat([current[:, :4]] + [p[:, :4] for p in past], 1)
    network = model.previous_frames.reweight.network
    x = torch.tanh(conv(torch.relu(conv(torch.relu(conv(x, network[0])), network[2])), network[4]))
    weighted = [p * (x[:, k : k + 1] * 5 + 5) for k, p in enumerate(past)]

    net, x = model.reconstruct, torch.cat([current, *weighted], 1)
    bottom, side = -x.shape[2] % 4, -x.shape[3] % 4
    height, width = x.shape[2:]
    x = F.pad(x, (0, side, 0, bottom))

    def pair(x, block, last=True):
        x = conv(torch.relu(conv(x, block[0])), block[2])
        return torch.relu(x) if last else x

    def up(x):
        return F.interpolate(x, size=(2 * x.shape[2], 2 * x.shape[3]), mode="bilinear", align_corners=False)

    one = pair(x, net.fine)
    two = pair(F.max_pool2d(one, 2, 2), net.middle)
    three = pair(F.max_pool2d(two, 2, 2), net.coarse)
    two = pair(torch.cat((up(three), two), 1), net.to_middle)
    return pair(torch.cat((up(two), one), 1), net.to_fine, last=False)[:, :, :height, :width]
