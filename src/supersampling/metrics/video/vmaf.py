"""VMAF (Li et al. 2016) by the libvmaf of imageio-ffmpeg's ffmpeg: one process per clip, fed frame by frame."""

import contextlib
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path
from typing import final

import numpy as np

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.video.base import Scoring, VideoMetric, to_bytes

SMALLEST = 32
"""Pixels per side; below 24 libvmaf crashes."""

_LOG = "vmaf.json"
# The model was trained on 8-bit 4:2:0 YUV of video range. It reads only luma, so that 4:2:0 loses nothing.
_TO_YUV = "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:flags=bicubic+accurate_rnd,format=yuv420p"


@final
class Vmaf(VideoMetric):
    """``vmaf``: the mean over the clip's frames, 0 to 100; NaN without frames.

    Output and target are rounded to 8 bits and converted to BT.709 yuv420p of video range. Identical clips score below
    100: a frame without motion, such as the first one, gets 97.43. Neighbouring frames are compared whatever their
    rate.

    Raises `UserError` for frames with a side below 32 pixels, and for a model that libvmaf does not have.

    Args:
        model: one of libvmaf's models: ``vmaf_v0.6.1`` (1080p seen from three screen heights), ``vmaf_4k_v0.6.1``,
            ``vmaf_v0.6.1neg``. A model other than the first is the metric's name: ``vmaf_4k_v0.6.1``.
        threads: libvmaf's number of threads; 0 uses every core.
    """

    better = {"vmaf*": "higher"}

    def __init__(self, model: str = "vmaf_v0.6.1", threads: int = 0) -> None:
        self.names = ("vmaf",) if model == "vmaf_v0.6.1" else (model,)
        self._model = model
        self._threads = threads or os.cpu_count() or 1

    def begin(self) -> Scoring:
        return _Process(self.names[0], f"model='version={self._model}':n_threads={self._threads}")


@final
class _Process(Scoring):
    """Process that receives output above target as raw RGB frames through stdin, splits them by crop filters, and
    writes the scores to a file."""

    def __init__(self, name: str, options: str) -> None:
        self._name = name
        self._options = options
        self._folder = tempfile.TemporaryDirectory(prefix="vmaf")
        self._process: subprocess.Popen | None = None

    def add(self, moment: Moment) -> None:
        frame = np.concatenate((to_bytes(moment.output), to_bytes(moment.target)))
        if self._process is None:
            self._process = self._start(frame.shape[1], frame.shape[0] // 2)
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(frame.data)
        except BrokenPipeError as error:
            self._process.wait()
            raise self._failure() from error

    def _start(self, width: int, height: int) -> subprocess.Popen:
        import imageio_ffmpeg

        if min(width, height) < SMALLEST:
            raise UserError(
                f"Frames of {width}x{height} pixels are too small for VMAF: "
                f"use at least {SMALLEST}x{SMALLEST}, or leave it out."
            )
        crop = f"crop={width}:{height}:0"
        graph = (
            f"[0:v]split[a][b];[a]{crop}:0,{_TO_YUV}[output];[b]{crop}:{height},{_TO_YUV}[target];"
            f"[output][target]libvmaf={self._options}:log_fmt=json:log_path={_LOG}"
        )
        source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{2 * height}", "-r", "30", "-i", "-"]
        quiet = ["-hide_banner", "-loglevel", "error"]
        # The process runs in its own folder, so that no path needs the escapes of filters. stderr goes to a file: a
        # full pipe would stop the process.
        with open(Path(self._folder.name) / "stderr", "wb") as stderr:
            return subprocess.Popen(
                [imageio_ffmpeg.get_ffmpeg_exe(), *quiet, *source, "-lavfi", graph, "-f", "null", "-"],
                cwd=self._folder.name,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=stderr,
            )

    def _failure(self) -> UserError:
        messages = (Path(self._folder.name) / "stderr").read_text(errors="replace").strip().splitlines()
        reason = messages[0] if messages else "no error message"
        return UserError(f"ffmpeg could not compute {self._name} ({reason}): check the model's name.")

    def finish(self) -> dict[str, float]:
        if self._process is None:
            return {self._name: math.nan}
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
        except BrokenPipeError as error:
            self._process.wait()
            raise self._failure() from error
        log = Path(self._folder.name) / _LOG
        if self._process.wait() != 0 or not log.exists():
            raise self._failure()
        return {self._name: float(json.loads(log.read_text())["pooled_metrics"]["vmaf"]["mean"])}

    def close(self) -> None:
        if self._process is not None:
            if self._process.poll() is None:
                self._process.kill()
            self._process.wait()
            if self._process.stdin is not None and not self._process.stdin.closed:
                # Data that the process has not read are not needed.
                with contextlib.suppress(BrokenPipeError):
                    self._process.stdin.close()
        self._folder.cleanup()
