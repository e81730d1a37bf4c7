"""What a whole clip is scored by. A metric sees every frame once and keeps a state whose size does not depend on the clip's
length; its values are known at the clip's end."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import Self, final

import numpy as np
from torch import Tensor

from supersampling.metrics.suite import Moment


class Scoring(ABC):
    """One clip on its way through a metric: ``add`` every frame from the first on, then ``finish``, inside ``with``, which
    gives back processes and files even if the clip is left early."""

    @abstractmethod
    def add(self, moment: Moment) -> None:
        """Take the clip's next frame. ``moment.previous`` is not read: a metric keeps what it needs."""

    @abstractmethod
    def finish(self) -> dict[str, float]:
        """The clip's values under the metric's ``names``; NaN where there is no value."""

    def close(self) -> None:  # noqa: B027 - most hold nothing
        """Give back what the scoring holds; more than once does no harm."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class VideoMetric(ABC):
    """Makes a `Scoring` for each clip; ``requires`` are the buffers that `Moment` has to carry."""

    names: tuple[str, ...]
    requires: frozenset[str]

    @abstractmethod
    def begin(self) -> Scoring: ...


@final
class VideoSuite(VideoMetric):
    """Several video metrics as one; none is no work."""

    def __init__(self, metrics: Sequence[VideoMetric] = ()) -> None:
        self._metrics = tuple(metrics)
        self.names = tuple(name for metric in self._metrics for name in metric.names)
        self.requires = frozenset({"target"}).union(*(m.requires for m in self._metrics))

    def begin(self) -> Scoring:
        return _Together([metric.begin() for metric in self._metrics])


@final
class _Together(Scoring):
    def __init__(self, scorings: Sequence[Scoring]) -> None:
        self._scorings = scorings

    def add(self, moment: Moment) -> None:
        for scoring in self._scorings:
            scoring.add(moment)

    def finish(self) -> dict[str, float]:
        return {name: value for scoring in self._scorings for name, value in scoring.finish().items()}

    def close(self) -> None:
        with ExitStack() as stack:  # one that fails does not keep the others open
            for scoring in self._scorings:
                stack.callback(scoring.close)


def to_bytes(image: Tensor) -> np.ndarray:
    """``(1, 3, H, W)`` in [0, 1] as 8 bit ``(H, W, 3)``, rounded to the nearest level; values outside are cut."""
    levels = (image[0].detach().clamp(0.0, 1.0) * 255.0).round().byte()
    return np.ascontiguousarray(levels.permute(1, 2, 0).cpu().numpy())
