"""The common part of the readers of PNG and EXR images: the type of an image and the check of its size."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError

MAX_PIXELS = 16 << 20
"""Larger images are an error before they are decoded: 4K has half as many pixels."""

Image = NDArray[np.float32]


def check_size(path: Path, width: int, height: int, size: tuple[int, int] | None) -> None:
    """Check the size of an image, and that it is ``size (width, height)`` if one is required.

    Raises:
        UserError: the image is empty, too large, or of a different size.
    """
    if width <= 0 or height <= 0 or width * height > MAX_PIXELS:
        raise UserError(f"{path} has {width}x{height} pixels: use images of at most {MAX_PIXELS} pixels.")
    if size is not None and (width, height) != size:
        raise UserError(
            f"{path} has {width}x{height} pixels: restore the image of {size[0]}x{size[1]} pixels that belongs to the "
            "clip."
        )


def check_readable(path: Path) -> None:
    """Raise `UserError` if a file is missing, is a folder, or the system refuses to open it."""
    try:
        path.open("rb").close()
    except FileNotFoundError as error:
        raise UserError(f"{path} is missing: restore it.") from error
    except OSError as error:
        raise UserError(f"{path} cannot be opened ({error.strerror}): make it a file that you may read.") from error
