"""Checkpoint files: written whole or not at all, and checked before anything of them is used."""

import io
import zipfile
import zlib
from pathlib import Path
from typing import Any

import torch
from lightning.fabric.plugins import TorchCheckpointIO
from torch import Tensor

from supersampling.errors import DamagedFile, UserError, describe_system_error, first_line
from supersampling.files import check_regular_file, replace_file

_HEAD = b"PK\x03\x04"
_FOLDER_MARK = 0x10  # of the attributes, as DOS has them
# Of zipfile, for archives that are not whole.
_BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, ValueError, OverflowError, MemoryError)
_RESTORE = "restore it from a copy, or train again (a run that has finished: with fresh=true)"


class WholeCheckpoints(TorchCheckpointIO):
    """Writes each checkpoint beside its place and renames it.

    Lightning writes to the folder for temporary files, from which it is copied if that is another file system: a full
    disk or a kill then leaves a part of a checkpoint in place of the previous one.
    """

    def save_checkpoint(self, checkpoint: dict[str, Any], path: Any, storage_options: Any = None) -> None:
        place = Path(path)
        temporary = place.with_name(f"{place.name}.part")
        buffer = io.BytesIO()  # PyTorch's own writer does not say that a disk is full
        torch.save(checkpoint, buffer)
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(buffer.getbuffer())
            replace_file(temporary, place)
        finally:
            temporary.unlink(missing_ok=True)


def load_checkpoint(path: Path) -> dict[str, Any]:
    """Return the content of a checkpoint: plain values, and at least ``state_dict``. No code of the file is run.

    Raises:
        DamagedFile: the file was truncated, or its content was changed after it was written.
        UserError: the file is missing, cannot be opened, or is not a checkpoint.
    """
    try:
        check_regular_file(path)
        _check_whole(path)
        content = _load(path)
    except FileNotFoundError as error:
        raise UserError(f"There is no checkpoint {path}: correct the path.") from error
    except OSError as error:
        condition = describe_system_error(error, path)
        raise condition or error from error
    weights = content.get("state_dict") if isinstance(content, dict) else None
    if not isinstance(weights, dict) or not all(isinstance(v, Tensor) for v in weights.values()):
        raise UserError(f"{path} is not a checkpoint (it has no state_dict): name a file of train.py.")
    return content


def _load(path: Path) -> Any:
    try:
        return torch.load(path, map_location="cpu", weights_only=True)
    except OSError:
        raise
    # PyTorch and pickle raise errors of many classes for files of other programs.
    except Exception as error:
        reason = first_line(error)
        raise UserError(f"{path} is not a checkpoint ({reason}): name a file of train.py.") from error


def _check_whole(path: Path) -> None:
    """Raise `DamagedFile` if the file is empty, truncated, or does not fit its checksums, which PyTorch ignores."""
    with path.open("rb") as file:
        head = file.read(len(_HEAD))
        if not head:
            raise _damaged(path, "is empty")
        if head != _HEAD[: len(head)]:
            return  # not an archive: an early version of PyTorch wrote it, or another program
        try:
            with zipfile.ZipFile(file) as archive:
                bad = archive.testzip() or next((i.filename for i in archive.infolist() if _reads_as_folder(i)), None)
        except _BROKEN as error:
            if isinstance(error, OSError) and describe_system_error(error, path):
                raise
            reason = first_line(error)
            raise _damaged(path, f"is truncated or damaged ({reason})") from error
    if bad:
        raise _damaged(path, f"is damaged ({ascii(bad)[:80]} does not fit its checksum or its attributes)")


def _reads_as_folder(member: zipfile.ZipInfo) -> bool:
    """Return whether a file of an archive is marked as a folder: PyTorch reads zeros then."""
    return bool(member.external_attr & _FOLDER_MARK and member.file_size)


def _damaged(path: Path, reason: str) -> DamagedFile:
    return DamagedFile(f"{path} {reason}: {_RESTORE}.", f"{path} {reason}")
