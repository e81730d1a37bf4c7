"""The command ``render``: data sets of built-in scenes, game tracks and glTF files."""

from pathlib import Path

import numpy as np
from hydra.utils import instantiate
from omegaconf import DictConfig
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.module import DataSource
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError
from supersampling.frames import BUFFERS


def render(cfg: DictConfig) -> None:
    """Render the buffers that the files of ``cfg.splits`` do not have, and print each file.

    Raises:
        UserError: an unknown split, buffer, scene or setting.
    """
    unknown = [split for split in cfg.splits if split not in SPLITS]
    if unknown:
        raise UserError(f"Unknown split {unknown[0]} in splits: use some of [{', '.join(SPLITS)}].")
    if isinstance(cfg.buffers, str) and cfg.buffers != "all":
        raise UserError(f"Invalid buffers={cfg.buffers}: use all, or a list such as [color,target].")
    buffers = frozenset(BUFFERS if cfg.buffers == "all" else cfg.buffers)
    if cfg.pictures:
        buffers |= {"color", "target"}
    source: DataSource = instantiate(cfg.data)
    files = source.files(list(cfg.splits), buffers)
    for split, paths in files.items():
        for path in paths:
            print(path)
            if cfg.pictures and split == cfg.splits[-1]:
                print(save_picture(path))


def save_picture(path: Path) -> Path:
    """Write a PNG beside a data set file: the last input of the first clip, enlarged, and its target, side by side."""
    store = DatasetFile(path)
    color, target = (store.read(name, 0, slice(-1, None))[0].transpose(1, 2, 0) for name in ("color", "target"))
    store.close()
    scale = target.shape[0] // color.shape[0]
    pair = np.concatenate((np.kron(color, np.ones((scale, scale, 1), dtype=np.float32)), target), axis=1)
    picture = path.with_suffix(".png")
    Image.fromarray(np.round(pair * 255.0).astype(np.uint8)).save(picture)
    return picture
