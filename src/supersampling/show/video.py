"""Short videos of a clip."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

from supersampling.errors import UserError
from supersampling.show.checks import check_warp
from supersampling.show.clip import ClipView
from supersampling.show.paint import Picture
from supersampling.show.panels import buffer_panel, warp_panels
from supersampling.show.scales import Scales, error_scale
from supersampling.show.sheet import Panel, Section, compose

_ABSENT = 58


def video_frames(clip: ClipView, reference: int, size: tuple[int, int], heading: str) -> Iterator[Picture]:
    """Yield pictures of every frame of a clip: input, target, motion and warp error, as far as the clip has them.

    The scales of colours are those of the frame ``reference`` in all frames. A panel that is missing in a frame is
    grey.
    """
    scales = Scales.measure(clip, reference)
    check = check_warp(clip, reference)
    full = error_scale(check.still_error) if check else None
    shown = [name for name in ("color", "target", "motion") if clip.has(name, clip.frames - 1)]
    for t in range(clip.frames):
        panels = [buffer_panel(clip, t, n, scales) if clip.has(n, t) else _absent(n, size) for n in shown]
        if full is not None:
            panels.append((warp_panels(clip, t, full)[1:2] or [_absent("|warped - target|", size)])[0])
        yield compose(f"{heading}, frame {t}", [Section("", panels)], size, 2)


def _absent(title: str, size: tuple[int, int]) -> Panel:
    return Panel(title, "missing in this frame", np.full((size[1], size[0], 3), _ABSENT, dtype=np.uint8))


def write_mp4(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """Write H.264 in MP4, which browsers play; all frames ``(h, w, 3)`` have the same size, both sides even."""
    writer = None
    try:
        for frame in frames:
            if writer is None:
                # Quality by constant rate factor; with the index in front, a browser plays while it loads.
                parameters = ["-crf", "14", "-preset", "medium", "-movflags", "+faststart"]
                writer = imageio_ffmpeg.write_frames(
                    str(path),
                    (frame.shape[1], frame.shape[0]),
                    fps=rate,
                    codec="libx264",
                    pix_fmt_out="yuv420p",
                    quality=None,
                    macro_block_size=2,
                    output_params=parameters,
                    ffmpeg_log_level="error",
                )
                writer.send(None)
            writer.send(np.ascontiguousarray(frame))
    finally:
        if writer is not None:
            writer.close()


def write_webp(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """Write an animated WebP that repeats endlessly: a README can show it, unlike MP4."""
    first, *rest = (Image.fromarray(frame) for frame in frames)
    first.save(path, save_all=True, append_images=rest, duration=1000.0 / rate, loop=0, quality=85, method=4)


_WRITERS = {"mp4": write_mp4, "webp": write_webp}


def check_format(name: str) -> str:
    """Return the name of a format unchanged.

    Raises:
        UserError: it is neither mp4 nor webp.
    """
    if name not in _WRITERS:
        raise UserError(f"Invalid video={name}: use {' or '.join(_WRITERS)}, or null for no video.")
    return name


def write_video(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """Write a video in the format given by the suffix of ``path``."""
    _WRITERS[path.suffix.removeprefix(".")](path, frames, rate)
