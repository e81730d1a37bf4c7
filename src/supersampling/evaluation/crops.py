"""Pictures of one clip per scene: crops of its last frame (raw input, output, target) at a position that depends on the
data only, and epipolar-plane images."""

from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image
from torch import Tensor

from supersampling.evaluation.score import ScoredFrame
from supersampling.metrics.video.epipolar import EpipolarPlane
from supersampling.ops.resample import repeat_upsample

SIZE = 96


def detailed_corner(target: Tensor, size: int) -> tuple[int, int]:
    """Return the top left ``(y, x)`` of the ``size`` square with the most fine detail of a ``(1, 3, H, W)`` target."""
    grey = target.mean(dim=1, keepdim=True)
    fine = (grey - F.avg_pool2d(grey, 5, stride=1, padding=2, count_include_pad=False)).abs()
    sums = F.avg_pool2d(fine, size, stride=4)
    best = int(sums.flatten().argmax())
    return best // sums.shape[-1] * 4, best % sums.shape[-1] * 4


def _image(values: Tensor) -> Image.Image:
    array = (values[0].clamp(0, 1) * 255.0).round().to(torch.uint8).permute(1, 2, 0).cpu().numpy()
    return Image.fromarray(np.ascontiguousarray(array))


def corner_of_crop(frame: ScoredFrame) -> tuple[tuple[int, int], int]:
    """Return the top left ``(y, x)`` and the side of a frame's crop."""
    size = min(SIZE, *frame.target.shape[-2:])
    return detailed_corner(frame.target, size), size


def save_crops(frame: ScoredFrame, folder: Path, index: int) -> None:
    """Write ``crops/<index>_<scene>{,_input,_target}.png`` of one scored frame, and
    ``state/<index>_<scene>_<name>.png`` of its pictures at the same position."""
    (y, x), size = corner_of_crop(frame)
    scale = frame.target.shape[-1] // frame.color.shape[-1]
    raw = repeat_upsample(frame.color, scale)
    stem = f"{index}_{file_name(frame.name.scene)}"
    for suffix, picture in (("", frame.output), ("_input", raw), ("_target", frame.target)):
        _image(picture[..., y : y + size, x : x + size]).save(folder / "crops" / f"{stem}{suffix}.png")
    for name, picture in frame.pictures.items():
        image = picture.expand(-1, 3, -1, -1)[..., y : y + size, x : x + size]
        _image(image).save(folder / "state" / f"{stem}_{name}.png")


def save_epipolar(plane: EpipolarPlane, folder: Path, stem: str) -> None:
    """Write ``<stem>{,_target}.png``: a row of the image over time, which runs downwards."""
    for suffix, image in zip(("", "_target"), plane.images()):
        Image.fromarray(image).save(folder / f"{stem}{suffix}.png")


def file_name(scene: str) -> str:
    """Return the name of a scene as part of a file name."""
    return scene.replace("/", "_")


def strip(folder: Path) -> Image.Image:
    """Return one picture of all crops in ``folder``: one row per scene with input, output and target side by side."""
    outputs = sorted(p for p in folder.glob("*.png") if not p.stem.endswith(("_input", "_target")))
    rows = []
    for path in outputs:
        trio = [path.with_name(f"{path.stem}_input.png"), path, path.with_name(f"{path.stem}_target.png")]
        cells = [np.asarray(Image.open(p).resize((3 * SIZE, 3 * SIZE), Image.Resampling.NEAREST)) for p in trio]
        rows.append(np.concatenate(cells, axis=1))
    return Image.fromarray(np.concatenate(rows, axis=0))
