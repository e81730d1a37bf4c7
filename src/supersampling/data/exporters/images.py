"""Writers of the PNG and EXR images of capture layouts."""

from pathlib import Path

import numpy as np
import OpenEXR
from numpy.typing import NDArray
from PIL import Image as Pillow


def write_png(path: Path, image: NDArray[np.float32]) -> None:
    """Write ``(h, w, 3)`` in [0, 1] as 8-bit RGB, rounded to nearest."""
    write_png8(path, np.round(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8))


def write_png8(path: Path, image: NDArray[np.uint8]) -> None:
    """Write ``(h, w, 3 or 4)`` as RGB or RGBA."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Pillow.fromarray(image).save(path, compress_level=1)


def write_exr(path: Path, image: NDArray[np.floating], channels: str, half: bool = True) -> None:
    """Write ``(h, w, len(channels))`` as half floats, clamped to their range, or as 32-bit floats."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if half:
        image = np.clip(image, -65504.0, 65504.0)
    stored = image.astype(np.float16 if half else np.float32)
    planes = {name: np.ascontiguousarray(stored[..., k]) for k, name in enumerate(channels)}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, planes).write(str(path))
