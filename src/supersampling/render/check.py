"""Checks of specifications and buffer names before rendering starts."""

from collections.abc import Iterable

from supersampling.data.spec import SPLITS, CaptureSpec
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.render.jitter import jitter_sequence, mip_bias
from supersampling.render.styles import camera_style


def check_buffers(names: Iterable[str]) -> None:
    """Raise `UserError` if a buffer does not exist.

    Raises:
        UserError: The message names the buffer and all existing ones.
    """
    unknown = sorted(set(names) - BUFFERS.keys())
    if unknown:
        raise UserError(f"Unknown buffer {unknown[0]}: use some of {', '.join(sorted(BUFFERS))}.")


def check_spec(spec: CaptureSpec) -> None:
    """Raise `UserError` if a specification cannot be rendered.

    Raises:
        UserError: The message names the value and the allowed ones.
    """
    if not 2 <= spec.scale <= 6:
        raise UserError(f"Invalid task.scale={spec.scale}: use an integer between 2 and 6.")
    if spec.split not in SPLITS:
        raise UserError(f"Unknown split {spec.split}: use one of {', '.join(SPLITS)}.")
    for name in ("clips", "frames", "samples"):
        if getattr(spec, name) < 1:
            raise UserError(f"Invalid data.{spec.split}.{name}={getattr(spec, name)}: use at least 1.")
    if not 1 <= spec.targets <= spec.frames:
        raise UserError(
            f"Invalid data.{spec.split}.targets={spec.targets}: "
            f"use a number between 1 and {spec.frames} (data.{spec.split}.frames)."
        )
    for side, window, frame in zip(("width", "height"), spec.window, spec.frame):
        if not 4 * spec.scale <= window <= frame:
            raise UserError(
                f"Invalid window {side} {window}: use a number between {4 * spec.scale} and {frame} (the frame's)."
            )
    camera_style(spec.camera)
    jitter_sequence(spec.jitter, spec.scale)
    mip_bias(spec.mip_bias, spec.scale)
