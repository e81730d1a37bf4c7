"""A clock that moves only when `Clock.work` is called, and methods that work for a known time."""

from typing import Any

import torch
from torch import nn

from supersampling.frames import Frame
from supersampling.models.base import Upsampler


class Clock:
    """A clock in seconds, with the interface of `time.perf_counter`."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def work(self, seconds: float) -> None:
        self.now += seconds


class Working(nn.Module):
    """A module that works for ``seconds``, then calls its children."""

    def __init__(self, clock: Clock, seconds: float, **children: nn.Module) -> None:
        super().__init__()
        self.clock, self.seconds = clock, seconds
        for name, child in children.items():
            self.add_module(name, child)

    def forward(self, x):
        self.clock.work(self.seconds)
        for child in self.children():
            x = child(x)
        return x


class WorkingMethod(Upsampler[Any]):
    """A method of known times.

    It takes 1 s itself; ``prepare`` 2 s, and in it the module ``warp`` twice 4 s; ``net`` 8 s with ``inner`` 16 s; two
    blocks of a list 32 s and 64 s.
    """

    requires = frozenset({"color"})

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self.scale, self.clock = 2, clock
        self.warp = Working(clock, 4.0)
        self.net = Working(clock, 8.0, inner=Working(clock, 16.0))
        self.blocks = nn.ModuleList([Working(clock, 32.0), Working(clock, 64.0)])

    def prepare(self, x):
        self.clock.work(2.0)
        return self.warp(self.warp(x))

    def forward(self, frame, state):
        self.clock.work(1.0)
        x = self.net(self.prepare(frame.color))
        for block in self.blocks:
            x = block(x)
        return x.repeat_interleave(2, -1).repeat_interleave(2, -2), ()


FRAME = Frame(color=torch.zeros(1, 3, 2, 2))
