"""What every upsampling method is: a recurrent step that says which buffers it reads."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from torch import Tensor, nn

from supersampling.frames import Frame

State = TypeVar("State")


class Upsampler(nn.Module, ABC, Generic[State]):
    """A recurrent step ``forward(frame, state) -> (output, state)``.

    ``output`` is ``(B, 3, scale * h, scale * w)`` in the method's own domain: display-referred colour in [0, 1] unless it
    says otherwise by `reference` and `present`. ``state`` is ``None`` on a clip's first frame and belongs to the model: callers
    hand it back unread. What is not finite in a frame is mended before a model sees it (`Frame.repair`); a model whose state
    would keep what is not finite for ever mends that itself. ``requires`` names the buffers that are read,
    ``compares`` those that a training's `reference` is made of.
    """

    scale: int
    requires: frozenset[str]
    compares: frozenset[str] = frozenset({"target"})

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        """What outputs are compared with in training, ``(B, T, 3, H, W)``, of a clip's ``compares`` buffers."""
        return clip["target"]

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        """The display-referred image ``(B, 3, H, W)`` in [0, 1] of an output of this ``frame``."""
        return output

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        """The linear radiance ``(B, 3, H, W)`` of an output; None of a method that knows display colours alone."""
        return None

    def pictured(self, state: State) -> Mapping[str, Tensor]:
        """What of a state is worth looking at: images ``(B, 1, H, W)`` in [0, 1], by name."""
        return {}

    @abstractmethod
    def forward(self, frame: Frame, state: State | None) -> tuple[Tensor, State]: ...

    def advance(self, frame: Frame, state: State | None) -> State:
        """The state alone, as ``forward`` gives it, for a frame whose output nobody asks for.

        A method whose state does not depend on its output leaves out here what only the output needs.
        """
        return self(frame, state)[1]

    def __call__(self, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        result: Any = super().__call__(frame.repair(), state)
        return result
