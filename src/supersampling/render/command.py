"""What ``render.py`` does: render data sets, read captures of other programs, write ours in their layouts."""

from pathlib import Path

import numpy as np
from hydra.utils import instantiate
from omegaconf import DictConfig
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.module import DataSource
from supersampling.data.readers.importing import import_capture
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError
from supersampling.frames import BUFFERS


def render(cfg: DictConfig) -> None:
    """Render what ``cfg.buffers`` lacks in ``cfg.splits``, or import or export, and print each file.

    Raises:
        UserError: an unknown split, buffer, scene or setting; a capture that cannot be read.
    """
    if cfg["import"] is not None:
        _import(cfg)
    elif cfg.export is not None:
        _export(cfg)
    else:
        _render(cfg)


def _render(cfg: DictConfig) -> None:
    unknown = [split for split in cfg.splits if split not in SPLITS]
    if unknown:
        raise UserError(f"splits={unknown} is not possible: use some of [{', '.join(SPLITS)}].")
    if isinstance(cfg.buffers, str) and cfg.buffers != "all":
        raise UserError(f"buffers={cfg.buffers} is not possible: use all, or a list such as [color,target].")
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


def _import(cfg: DictConfig) -> None:
    if cfg.path is None:
        raise UserError(f"import={cfg['import']} needs the capture's folder: add path=FOLDER.")
    paths = import_capture(
        cfg["import"], Path(cfg.path), Path(cfg.paths.data), scale=cfg.task.scale,
        convention=cfg.convention, jitter_convention=cfg.jitter_convention, reversed_depth=cfg.reversed_depth,
    )  # fmt: skip
    for path in paths:
        print(path)


def _export(cfg: DictConfig) -> None:
    if cfg.path is None or cfg.out is None:
        raise UserError(f"export={cfg.export} needs a data set file and a folder: add path=FILE.h5 out=FOLDER.")
    print(export(cfg.export, Path(cfg.path), Path(cfg.out)))


def save_picture(path: Path) -> Path:
    """A PNG beside a data set file: the first clip's last input, enlarged, and its target, side by side."""
    store = DatasetFile(path)
    color, target = (store.read(name, 0, slice(-1, None))[0].transpose(1, 2, 0) for name in ("color", "target"))
    store.close()
    scale = target.shape[0] // color.shape[0]
    pair = np.concatenate((np.kron(color, np.ones((scale, scale, 1), dtype=np.float32)), target), axis=1)
    picture = path.with_suffix(".png")
    Image.fromarray(np.round(pair * 255.0).astype(np.uint8)).save(picture)
    return picture
