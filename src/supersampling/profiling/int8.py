"""OpenVINO with its convolutions in int8, as a backend."""

import tempfile
from pathlib import Path
from typing import final

import torch

from supersampling.deploy.check import random_frames
from supersampling.deploy.quantise import missing, quantise
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OpenVINO
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, Clips, Setting, Stream
from supersampling.profiling.graphs import RunnerStream, write

PRECISION = "int8"


@final
class OpenVINOInt8(Backend):
    """Quantised when it is loaded.

    Args:
        clips: gives the frames to calibrate on, of a model and low-resolution size; without it they are random, which does for
            a time and for nothing else.
    """

    name = "openvino"

    def __init__(self, clips: Clips | None = None) -> None:
        self._clips = clips

    def missing(self, device: torch.device, precision: str) -> str:
        if precision != PRECISION:
            return f"This is int8 alone, not {precision}."
        return missing() if device.type == "cpu" else "OpenVINO does not run on CUDA."

    def calibrated(self, clips: Clips) -> Backend:
        return OpenVINOInt8(clips)

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        size = (setting.width, setting.height)
        clips = self._clips(model, size) if self._clips else [random_frames(model, size, 3, setting.jitters)]
        with tempfile.TemporaryDirectory(prefix="benchmark") as folder:
            path = quantise(write(model, setting, Path(folder)), clips)
            return RunnerStream(Runner(path, OpenVINO(threads=setting.threads)))
