"""What an evaluation computes: metrics of single frames and of whole clips, and nothing that was not asked for."""

from collections.abc import Sequence
from typing import final

from supersampling.metrics.suite import Metric, Suite
from supersampling.metrics.video.base import VideoMetric, VideoSuite


@final
class Metrics:
    """``of_frames`` are called with every frame, ``of_clips`` see a clip's frames one after another.

    ``requires`` are the buffers that a `Moment` has to carry for them.
    """

    def __init__(self, frames: Sequence[Metric], clips: Sequence[VideoMetric] = ()) -> None:
        self.of_frames, self.of_clips = Suite(frames), VideoSuite(clips)
        self.names = (*(name for metric in frames for name in metric.names), *self.of_clips.names)
        self.requires = self.of_frames.requires | self.of_clips.requires
