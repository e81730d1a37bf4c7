"""What can be rendered: a specification is checked once, before anything is begun."""

from collections.abc import Iterable

from supersampling.data.spec import SPLITS, CaptureSpec
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.render.jitter import jitter_sequence, mip_bias
from supersampling.render.styles import camera_style


def check_buffers(names: Iterable[str]) -> None:
    """Refuse a buffer that there is not.

    Raises:
        UserError: names it and all that there are.
    """
    unknown = sorted(set(names) - BUFFERS.keys())
    if unknown:
        raise UserError(f"There is no buffer {unknown[0]}: use some of {', '.join(sorted(BUFFERS))}.")


def check_spec(spec: CaptureSpec) -> None:
    """Refuse what cannot be rendered.

    Raises:
        UserError: names the value and what is allowed.
    """
    if not 2 <= spec.scale <= 6:
        raise UserError(f"task.scale={spec.scale} cannot be rendered: use an integer from 2 to 6.")
    if spec.split not in SPLITS:
        raise UserError(f"There is no split {spec.split}: use one of {', '.join(SPLITS)}.")
    for name in ("clips", "frames", "samples"):
        if getattr(spec, name) < 1:
            raise UserError(f"data.{spec.split}.{name}={getattr(spec, name)} is too small: use 1 or more.")
    if not 1 <= spec.targets <= spec.frames:
        raise UserError(
            f"data.{spec.split}.targets={spec.targets} is not possible: use 1 to {spec.frames} (data.{spec.split}.frames)."
        )
    for side, window, frame in zip(("width", "height"), spec.window, spec.frame):
        if not 4 * spec.scale <= window <= frame:
            raise UserError(f"A window {side} of {window} does not fit: use {4 * spec.scale} to {frame} (the frame's).")
    camera_style(spec.camera)
    jitter_sequence(spec.jitter, spec.scale)
    mip_bias(spec.mip_bias, spec.scale)
