"""The command ``import_capture``: a capture of another program as data set files."""

from pathlib import Path

from omegaconf import DictConfig

from supersampling.data.readers.importing import import_capture as read_capture
from supersampling.errors import UserError
from supersampling.settings import whole


def import_capture(cfg: DictConfig) -> None:
    """Import the capture in ``path`` and print each file.

    Raises:
        UserError: a setting is missing, or the capture cannot be read.
    """
    if cfg.layout is None or cfg.path is None:
        raise UserError(
            f"layout={cfg.layout} path={cfg.path} is incomplete: set layout=qrisp, nsrd or arm and path=FOLDER."
        )
    if cfg.reversed_depth not in (None, True, False) or type(cfg.reversed_depth) is int:
        raise UserError(f"Invalid reversed_depth={cfg.reversed_depth}: use true or false.")
    paths = read_capture(
        cfg.layout,
        Path(cfg.path),
        Path(cfg.paths.data),
        scale=whole(cfg, "task.scale"),
        convention=_word(cfg.convention),
        jitter_convention=_word(cfg.jitter_convention),
        reversed_depth=cfg.reversed_depth,
    )
    for path in paths:
        print(path)


def _word(value: object) -> str | None:
    """Return a convention as text; a number or a list is reported by the same sentence as an unknown word."""
    return None if value is None else str(value)
