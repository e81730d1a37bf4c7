"""Writes data set files in the capture layouts of the papers, to feed their own code with our renders."""

from collections.abc import Callable
from pathlib import Path

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters import arm, nsrd, qrisp
from supersampling.data.exporters.source import check_exportable, empty_folder
from supersampling.errors import UserError

Writer = Callable[[DatasetFile, Path], None]
WRITERS: dict[str, tuple[Writer, frozenset[str]]] = {
    "qrisp": (qrisp.export_qrisp, qrisp.NEEDED),
    "nsrd": (nsrd.export_nsrd, nsrd.NEEDED),
    "arm": (arm.export_arm, arm.NEEDED),
}


def export(layout: str, h5_path: Path, out_folder: Path) -> Path:
    """Write a data set file as a capture of ``layout`` (``qrisp``, ``nsrd``, ``arm``) into the empty or new ``out_folder``.

    Returns ``out_folder``, which `supersampling.data.readers.importing.import_capture` reads.

    Raises:
        UserError: the file lacks buffers or targets that the layout has, the layout has no such scale, the folder is not empty.
    """
    if layout not in WRITERS:
        raise UserError(f"There is no capture layout {layout!r}: use one of {', '.join(WRITERS)}.")
    write, needed = WRITERS[layout]
    store = DatasetFile(h5_path)
    try:
        check_exportable(store, needed, layout)
        write(store, empty_folder(out_folder))
    except OSError as error:
        raise UserError(f"Cannot write {error.filename or out_folder}: {error.strerror}.") from error
    finally:
        store.close()
    return out_folder
