"""What a frame is scored by: a list of metrics, each with the buffers that it reads."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from torch import Tensor

from supersampling.metrics.temporal import spatial_loss, temporal_loss


@dataclass(frozen=True)
class Moment:
    """A method's output beside the target, ``(1, 3, H, W)`` in [0, 1]; the previous two, none on a clip's first frame;
    and the low-resolution motion and dual motion ``(1, 2, h, w)`` where a metric asked for them.

    ``radiance``: the output's and the target's linear radiance, ``(1, 3, H, W)`` in [0, 65504] each, where a metric asked for
    ``target_radiance``; None of a method that knows display colours alone. ``size`` is the rendered ``(h, w)``."""

    output: Tensor
    target: Tensor
    previous: tuple[Tensor, Tensor] | None = None
    motion: Tensor | None = None
    motion_dual: Tensor | None = None
    radiance: tuple[Tensor, Tensor] | None = None
    size: tuple[int, int] | None = None


class Metric(ABC):
    """``metric(moment) -> {name: value}`` with the same ``names`` for every frame; NaN where there is no value."""

    names: tuple[str, ...]
    requires: frozenset[str]

    @abstractmethod
    def __call__(self, moment: Moment) -> dict[str, float]: ...


@final
class Temporal(Metric):
    """``spatial`` and ``temporal``, the two losses of DLCTUS table 10; a clip's first frame has none."""

    names = ("spatial", "temporal")
    requires = frozenset({"target", "motion"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        if moment.previous is None:
            return dict.fromkeys(self.names, float("nan"))
        assert moment.motion is not None
        now, before = (moment.output, moment.target), moment.previous
        values = (spatial_loss(*now, *before, moment.motion), temporal_loss(*now, *before, moment.motion))
        return dict(zip(self.names, (value.item() for value in values)))


@final
class Suite:
    """Several metrics as one."""

    def __init__(self, metrics: Sequence[Metric]) -> None:
        self._metrics = tuple(metrics)
        self.requires = frozenset({"target"}).union(*(m.requires for m in self._metrics))

    def __call__(self, moment: Moment) -> dict[str, float]:
        return {name: value for metric in self._metrics for name, value in metric(moment).items()}
