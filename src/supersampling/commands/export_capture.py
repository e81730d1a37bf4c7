"""The command ``export_capture``: a data set file in the layout of another program."""

from pathlib import Path

from omegaconf import DictConfig

from supersampling.data.exporters.exporting import export
from supersampling.errors import UserError


def export_capture(cfg: DictConfig) -> None:
    """Write the data set file ``path`` into the folder ``out`` and print the folder.

    Raises:
        UserError: a setting is missing, or the file cannot be written in this layout.
    """
    missing = [key for key in ("layout", "path", "out") if cfg[key] is None]
    if missing:
        raise UserError(f"{missing[0]} is not set: use layout=qrisp, nsrd or arm, path=FILE.h5 and out=FOLDER.")
    print(export(cfg.layout, Path(cfg.path), Path(cfg.out)))
