"""Base classes of the metrics of whole clips.

A metric sees every frame once and keeps a state whose size does not depend on the clip's length; its values are known
at the end of the clip.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import Self, final

import numpy as np
from torch import Tensor

from supersampling.metrics.base import Metric, Moment


class Scoring(ABC):
    """The scoring of one clip: ``add`` every frame from the first on, then ``finish``, inside a ``with`` block, which
    releases processes and files even if it is left early."""

    @abstractmethod
    def add(self, moment: Moment) -> None:
        """Process the next frame of the clip. Keep what later frames need: ``moment.previous`` may be missing."""

    @abstractmethod
    def finish(self) -> dict[str, float]:
        """Return the clip's values by the metric's ``names``; NaN where there is no value."""

    def close(self) -> None:  # noqa: B027 - most have nothing to release
        """Release processes and files; calling it again does nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class VideoMetric(Metric):
    """Metric of whole clips."""

    @abstractmethod
    def begin(self) -> Scoring:
        """Return the scoring of a new clip."""


@final
class VideoSuite(VideoMetric):
    """Several video metrics as one; without metrics it computes nothing."""

    def __init__(self, metrics: Sequence[VideoMetric] = ()) -> None:
        self._metrics = tuple(metrics)
        self.names = tuple(name for metric in self._metrics for name in metric.names)
        self.requires = frozenset({"target"}).union(*(metric.requires for metric in self._metrics))

    def begin(self) -> Scoring:
        return _Scorings([metric.begin() for metric in self._metrics])


@final
class _Scorings(Scoring):
    def __init__(self, scorings: Sequence[Scoring]) -> None:
        self._scorings = scorings

    def add(self, moment: Moment) -> None:
        for scoring in self._scorings:
            scoring.add(moment)

    def finish(self) -> dict[str, float]:
        return {name: value for scoring in self._scorings for name, value in scoring.finish().items()}

    def close(self) -> None:
        # A failing close does not leave the other scorings open.
        with ExitStack() as stack:
            for scoring in self._scorings:
                stack.callback(scoring.close)


def to_bytes(image: Tensor) -> np.ndarray:
    """Return an image ``(1, 3, H, W)`` in [0, 1] in 8 bits, ``(H, W, 3)``: rounded to the nearest level and clamped."""
    levels = (image[0].detach().clamp(0.0, 1.0) * 255.0).round().byte()
    return np.ascontiguousarray(levels.permute(1, 2, 0).cpu().numpy())
