"""ColorVideoVDP (Mantiuk et al. 2024) by its authors' package ``cvvdp``: visible differences, including flicker."""

import math
import tempfile
from typing import IO, Any, final

import numpy as np
import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.video.base import Scoring, VideoMetric, to_bytes

SMALLEST = 4
"""Pixels per side: the package's pyramid has no level for single pixels."""


@final
class ColorVideoVdp(VideoMetric):
    """``cvvdp``: quality in just-objectionable differences, at most 10; NaN without frames. Slow on a CPU.

    The package requires the length of a clip in advance: frames are rounded to 8 bits and kept in a temporary file, 6
    bytes per pixel and frame (746 MB for 60 frames at 1080p), which it then reads frame by frame. A clip of one frame
    is scored as an image.

    Raises `UserError` for frames with a side below 4 pixels, and, before a clip's first frame, if the package is not
    installed or does not have the display.

    Args:
        frame_rate: frames per second at which the clip is watched.
        display: one of the package's display models: ``standard_fhd`` (24 inch, 1920x1080, 200 cd/m^2, office light,
            seen from two screen heights), ``standard_4k``, ... Frames count as a part of that screen, pixel for pixel.
            A different display changes the metric's name (``cvvdp_standard_4k``), and so does a frame rate other than
            60 (``cvvdp_30fps``).
    """

    better = {"cvvdp*": "higher"}

    def __init__(self, frame_rate: float = 60.0, display: str = "standard_fhd") -> None:
        if frame_rate <= 0.0:
            raise UserError(f"Invalid frame_rate={frame_rate} of ColorVideoVDP: use a positive number, such as 60.")
        self._frame_rate, self._display = frame_rate, display
        screen = "" if display == "standard_fhd" else f"_{display}"
        rate = "" if frame_rate == 60.0 else f"_{frame_rate:g}fps"
        self.names = (f"cvvdp{screen}{rate}",)

    def begin(self) -> Scoring:
        try:
            import pycvvdp
        except ImportError as error:
            raise UserError(
                f"ColorVideoVDP needs the package cvvdp ({error}): run pip install cvvdp huggingface_hub."
            ) from error
        try:
            photometry = pycvvdp.vvdp_display_photometry.load(self._display, [])
        except pycvvdp.vq_exception as error:
            raise UserError(
                f"Unknown display={self._display} of ColorVideoVDP: use standard_fhd, standard_4k or standard_hdr_pq."
            ) from error
        return _Spool(self.names[0], self._frame_rate, self._display, photometry)


@final
class _Spool(Scoring):
    def __init__(self, name: str, frame_rate: float, display: str, photometry: Any) -> None:
        self._name, self._frame_rate, self._display = name, frame_rate, display
        self._photometry = photometry
        self._file: IO[bytes] = tempfile.TemporaryFile(prefix="cvvdp")  # noqa: SIM115 - `close` closes it
        self._size = (0, 0)
        self._device = torch.device("cpu")
        self._frames = 0

    def add(self, moment: Moment) -> None:
        height, width = self._size = (moment.target.shape[-2], moment.target.shape[-1])
        if min(height, width) < SMALLEST:
            raise UserError(
                f"Frames of {width}x{height} pixels are too small for ColorVideoVDP: "
                f"use at least {SMALLEST}x{SMALLEST}, or leave it out."
            )
        self._device = moment.target.device
        for image in (moment.output, moment.target):
            self._file.write(to_bytes(image).data)
        self._frames += 1

    def finish(self) -> dict[str, float]:
        if not self._frames:
            return {self._name: math.nan}
        import pycvvdp

        metric = pycvvdp.cvvdp(display_name=self._display, quiet=True, device=self._device)
        film = _Film(self._file, (*self._size, self._frames), self._frame_rate, self._photometry)
        with torch.no_grad():
            quality, _ = metric.predict_video_source(film)
        return {self._name: float(quality)}

    def close(self) -> None:
        self._file.close()


@final
class _Film:
    """The package's video source. Each frame is read on request: a memory-mapped file would stay in memory.

    Args:
        file: output and target of each frame, 8 bits, ``(H, W, 3)``.
        size: ``(H, W, frames)``.
        display: the package's photometric model, which converts values to light.
    """

    def __init__(self, file: IO[bytes], size: tuple[int, int, int], frame_rate: float, display: Any) -> None:
        self._file, self._size, self._frame_rate, self._display = file, size, frame_rate, display

    def get_video_size(self) -> tuple[int, int, int]:
        return self._size

    def get_frames_per_second(self) -> float:
        return self._frame_rate

    def get_batch_size(self) -> int:
        return 1

    def get_test_frame(self, frame: int, device: torch.device, colorspace: str) -> Tensor:
        return self._light(2 * frame, device, colorspace)

    def get_reference_frame(self, frame: int, device: torch.device, colorspace: str) -> Tensor:
        return self._light(2 * frame + 1, device, colorspace)

    def _light(self, index: int, device: torch.device, colorspace: str) -> Tensor:
        """Return the light of the file's image number ``index``, ``(1, 3, 1, H, W)``."""
        height, width, _ = self._size
        count = height * width * 3
        self._file.seek(index * count)
        values = np.frombuffer(bytearray(self._file.read(count)), dtype=np.uint8).reshape(height, width, 3)
        image = torch.from_numpy(values).to(device).permute(2, 0, 1)[None, :, None].float() / 255.0
        light: Tensor = self._display.source_2_target_colorspace(image, colorspace)
        return light
