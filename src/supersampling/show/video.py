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
    """Every frame of a clip: input and target, motion and warp error, whichever of them the clip has.

    Colours mean the same in all frames: what they do in the frame ``reference``. Where a frame lacks what others have, its
    place is grey.
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
    return Panel(title, "not there in this frame", np.full((size[1], size[0], 3), _ABSENT, dtype=np.uint8))


def write_mp4(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """H.264 in MP4, as browsers play it; all frames ``(h, w, 3)`` of one size, both sides even."""
    writer = None
    try:
        for frame in frames:
            if writer is None:
                # Quality by constant rate factor; the index in front lets a browser play while it loads.
                how = ["-crf", "14", "-preset", "medium", "-movflags", "+faststart"]
                writer = imageio_ffmpeg.write_frames(
                    str(path), (frame.shape[1], frame.shape[0]), fps=rate, codec="libx264", pix_fmt_out="yuv420p",
                    quality=None, macro_block_size=2, output_params=how, ffmpeg_log_level="error",
                )  # fmt: skip
                writer.send(None)
            writer.send(np.ascontiguousarray(frame))
    finally:
        if writer is not None:
            writer.close()


def write_webp(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """Animated WebP, endlessly repeating, which a README shows where it shows no MP4."""
    first, *rest = (Image.fromarray(frame) for frame in frames)
    first.save(path, save_all=True, append_images=rest, duration=1000.0 / rate, loop=0, quality=85, method=4)


_WRITERS = {"mp4": write_mp4, "webp": write_webp}


def check_format(name: str) -> str:
    """The name itself.

    Raises:
        UserError: neither mp4 nor webp.
    """
    if name not in _WRITERS:
        raise UserError(f"video={name} cannot be written: use {' or '.join(_WRITERS)}, or null for none.")
    return name


def write_video(path: Path, frames: Iterable[Picture], rate: float) -> None:
    """Write a video in the format that ``path`` ends with."""
    _WRITERS[path.suffix.removeprefix(".")](path, frames, rate)
