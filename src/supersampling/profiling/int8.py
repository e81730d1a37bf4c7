"""OpenVINO with convolutions in int8, as a backend."""

import tempfile
from pathlib import Path
from typing import final

import torch

from supersampling.deploy.check import random_frames
from supersampling.deploy.quantise import missing, quantise
from supersampling.deploy.runtimes import OpenVINO
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, Clips, LoadOptions, Stream
from supersampling.profiling.graphs import RunnerStream, write

PRECISION = "int8"


@final
class OpenVINOInt8(Backend):
    """OpenVINO with convolutions that are quantised when a method is loaded.

    Args:
        clips: the frames to calibrate with; None takes random frames, which are good enough to measure time only.
    """

    name = "openvino"

    def __init__(self, clips: Clips | None = None) -> None:
        self._clips = clips

    def missing(self, device: torch.device, precision: str) -> str:
        if precision != PRECISION:
            return f"This backend computes in int8 only, not in {precision}: use precisions=[int8]."
        return missing() if device.type == "cpu" else "OpenVINO does not run on CUDA."

    def with_calibration(self, clips: Clips) -> Backend:
        return OpenVINOInt8(clips)

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        size = (options.width, options.height)
        clips = self._clips(model, size) if self._clips else [random_frames(model, size, 3, options.jitters)]
        with tempfile.TemporaryDirectory(prefix="benchmark") as folder:
            path = quantise(write(model, options, Path(folder)), clips)
            return RunnerStream(path, OpenVINO(threads=options.threads))
