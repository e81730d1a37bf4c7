"""Small synthetic clips for the tests of video metrics."""

import torch
import torch.nn.functional as F

from supersampling.metrics.base import Moment


def texture(height, width, seed=0):
    """Smooth colours in [0.1, 0.9]."""
    coarse = torch.rand(1, 3, height // 4 + 1, width // 4 + 1, generator=torch.Generator().manual_seed(seed))
    return 0.1 + 0.8 * F.interpolate(coarse, size=(height, width), mode="bicubic", align_corners=True).clamp(0, 1)


def pan(frames, height=48, width=64, step=2):
    """Return the frames of a camera that moves ``step`` pixels per frame to the right, and their motion at half
    resolution."""
    wide = texture(height, width + step * frames)
    motion = torch.zeros(1, 2, height // 2, width // 2)
    motion[:, 0] = step / width
    return [wide[..., step * t : step * t + width] for t in range(frames)], [motion] * frames


def passing_square(frames, height=48, width=64, step=4, side=16):
    """Return a bright square that crosses a still background: frames, motion and dual motion at half resolution."""
    ground = texture(height, width) * 0.5
    images, motions, duals = [], [], []
    for t in range(frames):
        left = 4 + step * t
        image, motion = ground.clone(), torch.zeros(1, 2, height // 2, width // 2)
        rows = slice(16, 16 + side)
        image[..., rows, left : left + side] = 0.95
        low_rows = slice(8, 8 + side // 2)
        motion[:, 0, low_rows, left // 2 : (left + side) // 2] = -step / width
        dual = motion.clone()
        dual[:, 0, low_rows, (left - step) // 2 : left // 2] = -step / width  # what it has just uncovered
        images.append(image)
        motions.append(motion)
        duals.append(dual)
    return images, motions, duals


def moments(outputs, targets, motions=None, duals=None):
    """Yield the moments of a clip."""
    previous = None
    for t, (output, target) in enumerate(zip(outputs, targets)):
        motion = None if motions is None else motions[t]
        dual = None if duals is None else duals[t]
        yield Moment(output=output, target=target, previous=previous, motion=motion, motion_dual=dual)
        previous = (output, target)


def score(metric, outputs, targets, motions=None, duals=None):
    """Return the values of a video metric for a clip."""
    with metric.begin() as scoring:
        for moment in moments(outputs, targets, motions, duals):
            scoring.add(moment)
        return scoring.finish()


def noisy(images, sigma, seed=1):
    generator = torch.Generator().manual_seed(seed)
    return [(image + sigma * torch.randn(image.shape, generator=generator)).clamp(0, 1) for image in images]


def blurred(images, radius):
    side = 2 * radius + 1
    return [F.avg_pool2d(F.pad(i, (radius,) * 4, mode="replicate"), side, stride=1) for i in images]


def flickering(images, height):
    """Return the images with a brighter fourth frame."""
    return [image + height * (t == 3) for t, image in enumerate(images)]


def ghosted(images, weight):
    """Blend each frame with the previous one."""
    before = [images[0], *images[:-1]]
    return [torch.lerp(image, last, weight) for image, last in zip(images, before)]
