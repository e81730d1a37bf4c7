"""Small ENSS networks, and clips to run them on."""

from functools import partial

import torch

from supersampling.frames import Frame
from supersampling.models.enss import ENSS
from supersampling.stages.confine import StraightThrough
from supersampling.stages.flow import MotionVectors
from supersampling.stages.history import Blended
from supersampling.stages.kernel_prediction import FirstAndLast
from supersampling.stages.motion_grid import FrontmostOfBlock
from supersampling.stages.reproject import Bilinear

SMALL = {"width": 24, "layers": 4}


def enss(scale=2, features=8, depth=1, **stages):
    torch.manual_seed(0)
    defaults = {
        "flow": MotionVectors(),
        "motion_grid": FrontmostOfBlock(8),
        "reproject": Bilinear(),
        "history": Blended(),
        "confine": StraightThrough(),
        "kernel_prediction": partial(FirstAndLast, **SMALL),
    }
    return ENSS(scale, features, depth, **(defaults | stages))


def clip(frames=3, b=2, h=5, w=6, seed=0, motion=0.1, dtype=torch.float32):
    g = torch.Generator().manual_seed(seed)
    return {
        "color": torch.rand(b, frames, 3, h, w, generator=g, dtype=dtype),
        "depth": torch.rand(b, frames, 1, h, w, generator=g, dtype=dtype),
        "motion": torch.randn(b, frames, 2, h, w, generator=g, dtype=dtype) * motion,
        "jitter": torch.rand(b, frames, 2, generator=g, dtype=dtype) - 0.5,
    }


def run(model, buffers):
    inputs = {name: buffer for name, buffer in buffers.items() if name in model.requires}
    outputs, state = [], None
    for t in range(inputs["color"].shape[1]):
        output, state = model(Frame.from_clip(inputs, t), state)
        outputs.append(output)
    return torch.stack(outputs, dim=1), state
