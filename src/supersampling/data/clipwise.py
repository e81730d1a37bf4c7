"""A data set file that several processes write clip by clip, and that is resumable after a kill at any moment."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import h5py
from filelock import FileLock, Timeout

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, buffers_in, join_clips
from supersampling.errors import UserError
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
        """Return the buffers that are missing in the file.

        Raises:
            UserError: the file is truncated, or its content does not match its name.
        """
        if not self.path.exists():
            return self._names
        file = DatasetFile(self.path)
        spec, buffers = file.spec, file.buffers
        file.close()
        if spec != self.spec:
            raise UserError(f"{self.path} holds {spec.to_json()}, which does not match its name: remove the file.")
        return self._names - buffers

    def waiting(self) -> list[int]:
        """Return the clips that are not finished."""
        missing = self.missing()
        return [k for k in range(self.spec.clips) if not self._has(k, missing)] if missing else []

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
        try:
            return names <= buffers_in(self._part(clip))
        # Another process has just finished the file.
        except FileNotFoundError:
            return False

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
                with h5py.File(parts[0], "r") as first:
                    notes = {str(key): str(value) for key, value in first.attrs.items()}
                join_clips(self.path, self.spec, parts, missing, notes | dict(attributes))
        if self.parts.exists():
            shutil.rmtree(self.parts, ignore_errors=True)
