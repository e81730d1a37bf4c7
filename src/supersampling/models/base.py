"""The interface of every upsampling method: a recurrent step that declares which buffers it reads."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Generic, TypeVar, final

from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.stages.gate import Gate

State = TypeVar("State")


class Upsampler(nn.Module, ABC, Generic[State]):
    """A recurrent step ``forward(frame, state) -> (output, state)``.

    ``output`` is ``(B, 3, scale * h, scale * w)`` in the method's own domain: display-referred colour in [0, 1], unless
    `reference` and `present` are overridden. ``state`` is ``None`` on a clip's first frame and belongs to the model:
    callers pass it back without reading it.

    Callers use ``model(frame, state)`` and `advance`; both replace values that are not finite (`Frame.repair`) before
    `forward` or `forward_state` sees the frame. A model whose state would keep such a value for ever repairs its state
    itself.

    ``requires`` names the buffers that are read, ``compares`` those from which `reference` is computed in training.
    ``extremes`` are the gates that stress tests hold open or shut; stages declare theirs in the same way.
    ``over_time`` names those of `step_images` that are drawn over consecutive frames.
    """

    scale: int
    requires: frozenset[str]
    compares: frozenset[str] = frozenset({"target"})
    extremes: tuple[Gate, ...] = ()
    over_time: frozenset[str] = frozenset()

    @property
    def reads_jitter(self) -> bool:
        """Whether the model knows where in its pixel a sample was taken; samples of other places misalign one that
        does not."""
        return "jitter" in self.requires

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        """Return what outputs are compared with in training, ``(B, T, 3, H, W)``, from ``compares`` buffers."""
        return clip["target"]

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        """Return the display-referred image ``(B, 3, H, W)`` in [0, 1] of an output for this ``frame``."""
        return output

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        """Return the linear radiance ``(B, 3, H, W)`` of an output; None if only display colours are known."""
        return None

    def state_images(self, state: State) -> Mapping[str, Tensor]:
        """Return the parts of a state that are worth looking at: images ``(B, 1, H, W)`` in [0, 1], by name."""
        return {}

    def step_images(self, frame: Frame, state: State | None) -> Mapping[str, Tensor]:
        """Return what the step from ``state`` to this frame computes on its way and is worth looking at.

        Images ``(B, 1, H, W)`` or ``(B, 3, H, W)`` in [0, 1] by name, for pictures only: what `forward` computes may be
        computed again.
        """
        return {}

    @abstractmethod
    def forward(self, frame: Frame, state: State | None) -> tuple[Tensor, State]: ...

    def forward_state(self, frame: Frame, state: State | None) -> State:
        """Return the new state only, equal to that of `forward`.

        Override this where the state does not depend on the output, to leave out what only the output needs.
        """
        return super().__call__(frame, state)[1]

    @final
    def advance(self, frame: Frame, state: State | None) -> State:
        """Return the new state only, for a frame whose output is not used."""
        return self.forward_state(frame.repair(), state)

    @final
    def pictured(self, frame: Frame, state: State | None) -> Mapping[str, Tensor]:
        """Return `step_images` of the repaired frame; ``state`` is the one before it."""
        return self.step_images(frame.repair(), state)

    def __call__(self, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        result: Any = super().__call__(frame.repair(), state)
        return result
