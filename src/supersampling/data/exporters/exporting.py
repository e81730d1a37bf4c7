"""Export of data set files to the capture layouts of the papers, as input for the authors' code."""

from collections.abc import Callable
from pathlib import Path

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters import arm, nsrd, qrisp
from supersampling.data.exporters.source import check_exportable, empty_folder
from supersampling.errors import UserError

Writer = Callable[[DatasetFile, Path], None]
WRITERS: dict[str, tuple[Writer, frozenset[str]]] = {
    "qrisp": (qrisp.export_qrisp, qrisp.REQUIRED),
    "nsrd": (nsrd.export_nsrd, nsrd.REQUIRED),
    "arm": (arm.export_arm, arm.REQUIRED),
}


def export(layout: str, h5_path: Path, out_folder: Path) -> Path:
    """Write a data set file as a capture of ``layout`` (``qrisp``, ``nsrd``, ``arm``) into the empty or new
    ``out_folder``.

    Returns ``out_folder``, which `supersampling.data.readers.importing.import_capture` reads.

    Raises:
        UserError: buffers or targets of the layout are missing, the layout does not have the scale, or the folder is
        not empty.
    """
    if layout not in WRITERS:
        raise UserError(f"Unknown capture layout {layout}: use one of {', '.join(WRITERS)}.")
    write, required = WRITERS[layout]
    file = DatasetFile(h5_path)
    try:
        check_exportable(file, required, layout)
        write(file, empty_folder(out_folder))
    except OSError as error:
        raise UserError(
            f"Cannot write {error.filename or out_folder} ({error.strerror}): export into another folder."
        ) from error
    finally:
        file.close()
    return out_folder
