"""Base classes of all metrics, and the record of a frame that they read."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, final

from torch import Tensor

Better = Literal["higher", "lower", "neither"]


@dataclass(frozen=True, kw_only=True)
class Moment:
    """One frame of a clip: a method's output, the target, and the buffers that the metrics require.

    Args:
        output: ``(1, 3, H, W)`` in [0, 1].
        target: as ``output``.
        previous: output and target of the previous frame; None for a clip's first frame.
        motion: low-resolution motion ``(1, 2, h, w)``; None unless a metric requires it.
        motion_dual: as ``motion``.
        radiance: linear radiance of output and target, ``(1, 3, H, W)`` in [0, 65504] each; None unless a metric
            requires ``target_radiance``, and for a method that has display colours only.
        size: the rendered ``(h, w)``.
    """

    output: Tensor
    target: Tensor
    previous: tuple[Tensor, Tensor] | None = None
    motion: Tensor | None = None
    motion_dual: Tensor | None = None
    radiance: tuple[Tensor, Tensor] | None = None
    size: tuple[int, int] | None = None


class Metric(ABC):
    """Base class of the metrics of frames and of clips.

    Attributes:
        better: for each name, whether higher or lower values are better; ``neither`` for values that describe the
            target or the clip and for ratios, which are best near 1. A name that depends on an argument is stated as a
            pattern with ``*``; the first matching pattern of the class counts.
        names: the keys of ``better``; a class with patterns sets its names in ``__init__``.
        requires: the buffers that a `Moment` has to carry.
    """

    better: ClassVar[Mapping[str, Better]]
    names: tuple[str, ...]
    requires: frozenset[str] = frozenset({"target"})

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if "better" in vars(cls) and not any("*" in name for name in cls.better):
            cls.names = tuple(cls.better)


class FrameMetric(Metric):
    """Metric of single frames: ``metric(moment) -> {name: value}``."""

    @abstractmethod
    def measure(self, moment: Moment) -> Sequence[float]:
        """Return one value for each of ``names``, in their order; NaN where there is no value."""

    def __call__(self, moment: Moment) -> dict[str, float]:
        return dict(zip(self.names, self.measure(moment), strict=True))


@final
class FrameSuite(FrameMetric):
    """Several metrics of frames as one."""

    def __init__(self, metrics: Sequence[FrameMetric]) -> None:
        self._metrics = tuple(metrics)
        self.names = tuple(name for metric in self._metrics for name in metric.names)
        self.requires = frozenset({"target"}).union(*(metric.requires for metric in self._metrics))

    def measure(self, moment: Moment) -> list[float]:
        return [value for metric in self._metrics for value in metric.measure(moment)]
