"""The command ``import_capture``: a capture of another program as data set files."""

from pathlib import Path

from omegaconf import DictConfig

from supersampling.data.readers.importing import import_capture as read_capture
from supersampling.errors import UserError


def import_capture(cfg: DictConfig) -> None:
    """Import the capture in ``path`` and print each file.

    Raises:
        UserError: a setting is missing, or the capture cannot be read.
    """
    if cfg.layout is None or cfg.path is None:
        raise UserError(
            f"layout={cfg.layout} path={cfg.path} is incomplete: set layout=qrisp, nsrd or arm and path=FOLDER."
        )
    paths = read_capture(
        cfg.layout,
        Path(cfg.path),
        Path(cfg.paths.data),
        scale=cfg.task.scale,
        convention=cfg.convention,
        jitter_convention=cfg.jitter_convention,
        reversed_depth=cfg.reversed_depth,
    )
    for path in paths:
        print(path)
