"""What every upsampling method is: a recurrent step that says which buffers it reads."""

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from torch import Tensor, nn

from supersampling.frames import Frame

State = TypeVar("State")


class Upsampler(nn.Module, ABC, Generic[State]):
    """A recurrent step ``forward(frame, state) -> (output, state)``.

    ``output`` is ``(B, 3, scale * h, scale * w)``, display-referred, in [0, 1]. ``state`` is ``None`` on a clip's
    first frame and belongs to the model: callers hand it back unread. ``requires`` names the buffers that are read.
    """

    scale: int
    requires: frozenset[str]

    @abstractmethod
    def forward(self, frame: Frame, state: State | None) -> tuple[Tensor, State]: ...

    def __call__(self, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        result: Any = super().__call__(frame, state)
        return result
