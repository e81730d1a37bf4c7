"""A data set file that several processes write clip by clip, and that is resumable after a kill at any moment."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

from filelock import FileLock, Timeout

from supersampling.data.content import read_text
from supersampling.data.dataset_file import DatasetFile
from supersampling.data.hdf5 import MissingFile, open_hdf5, reading
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, buffers_in, join_clips
from supersampling.errors import DamagedFile, UserError
from supersampling.files import set_aside
from supersampling.frames import BUFFERS

WriteClip = Callable[[int, ClipWriter, frozenset[str]], None]


class ClipwiseFile:
    """The buffers ``names`` of ``spec`` as one file under ``folder``.

    Clips are separate files in a folder next to the file until all are finished; then they are joined, and the result
    is renamed to its final name. A clip in progress is locked; the system releases the lock if the process dies.
    Buffers that are missing in a finished file are added in the same way.
    """

    def __init__(self, spec: CaptureSpec, folder: Path, names: frozenset[str]) -> None:
        self.spec, self.path, self._names = spec, folder / spec.file_name, names
        self.parts = folder / f"{spec.file_name}.clips"
        self._lock = folder / f".{spec.file_name}.lock"

    def missing(self) -> frozenset[str]:
        """Return the buffers that are missing in the file; a broken file is renamed and counts as missing.

        Raises:
            UserError: the file cannot be opened, or its content does not match its name.
        """
        try:
            file = self._open()
        except DamagedFile:
            file = self._set_aside()
        if file is None:
            return self._names
        file.close()
        if file.spec != self.spec:
            raise UserError(
                f"{self.path} holds {file.spec.to_json()}, which does not match its name: move it to another folder."
            )
        return self._names - file.buffers

    def _open(self) -> DatasetFile | None:
        try:
            return DatasetFile(self.path)
        except MissingFile:
            return None

    def _set_aside(self) -> DatasetFile | None:
        """Rename the file if it is still broken, so that no process renames what another has just written."""
        with FileLock(self._lock):
            try:
                return self._open()
            except DamagedFile as error:
                set_aside(self.path, error, "its clips are made again")
        return None

    def waiting(self) -> list[int]:
        """Return the clips that are not finished."""
        missing = self.missing()
        return [k for k in range(self.spec.clips) if not self._has(k, missing)] if missing else []

    def begun_with(self, attribute: str) -> str | None:
        """Return an attribute of the file, or else of its first finished clip; None if there is neither."""
        file = self._open()
        if file is not None:
            file.close()
            return file.attributes.get(attribute)
        for path in sorted(self.parts.glob("*.h5")):
            if buffers_in(path):
                with open_hdf5(path) as part, reading(path, "its attributes"):
                    return read_text(part, attribute) if attribute in part.attrs else None
        return None

    def work(self, write: WriteClip, attributes: Mapping[str, str]) -> None:
        """Write every clip that no other process is writing, and join the clips if all are finished.

        ``write(clip, writer, names)`` writes all frames of the buffers ``names``; its notes on the clip, and
        ``attributes``, become attributes of the file.

        Raises:
            UserError: the folder cannot be written.
        """
        if self.missing():
            try:
                self.parts.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise UserError(
                    f"Cannot create the folder {self.parts} ({error.strerror}): set paths.data to another folder."
                ) from error
        for clip in self.waiting():
            self._write_clip(clip, write)
        if not self.waiting():
            self._join(attributes)

    def _part(self, clip: int) -> Path:
        return self.parts / f"{clip:04d}.h5"

    def _has(self, clip: int, names: frozenset[str]) -> bool:
        return names <= buffers_in(self._part(clip))

    def _write_clip(self, clip: int, write: WriteClip) -> None:
        part = self._part(clip)
        try:
            with FileLock(part.with_suffix(".lock"), timeout=0):
                missing = self.missing()
                # In this order: another process may finish the file and remove its clips at any moment.
                if self._has(clip, missing) or not self.missing():
                    return
                with ClipWriter(part, self._lengths(missing)) as writer:
                    write(clip, writer, missing)
        except Timeout:
            return
        except FileNotFoundError:
            if self.missing():
                raise

    def _lengths(self, names: frozenset[str]) -> dict[str, int]:
        """Return the number of frames per clip that have each of these buffers."""
        spec = self.spec
        return {n: spec.targets if BUFFERS[n].resolution == "high" else spec.frames for n in sorted(names)}

    def _join(self, attributes: Mapping[str, str]) -> None:
        with FileLock(self._lock):
            missing = self.missing()
            if missing:
                parts = [self._part(k) for k in range(self.spec.clips)]
                with open_hdf5(parts[0]) as first, reading(parts[0], "its attributes"):
                    notes = {str(key): read_text(first, key) for key in first.attrs}
                join_clips(self.path, self.spec, parts, missing, notes | dict(attributes))
        if self.parts.exists():
            shutil.rmtree(self.parts, ignore_errors=True)
