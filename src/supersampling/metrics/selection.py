"""The metrics of an evaluation: only those that the configuration names are computed."""

from collections.abc import Sequence
from typing import final

from supersampling.metrics.base import FrameMetric, FrameSuite
from supersampling.metrics.video.base import VideoMetric, VideoSuite


@final
class Metrics:
    """Metrics of frames and of clips, with their names and the buffers that they require.

    Args:
        frames: called with every frame.
        clips: receive the frames of a clip one after another.
    """

    def __init__(self, frames: Sequence[FrameMetric], clips: Sequence[VideoMetric] = ()) -> None:
        self.frames, self.clips = FrameSuite(frames), VideoSuite(clips)
        self.names = (*self.frames.names, *self.clips.names)
        self.requires = self.frames.requires | self.clips.requires
