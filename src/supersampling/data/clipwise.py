"""A data set file that is made clip by clip: resumable after a kill at any moment, by several processes at once."""

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

    Clips are kept one by one in a folder beside the file until all are there; then they are joined, and the file is renamed into
    place. One under way is claimed by a lock, which the system lets go when its process dies. Buffers that a finished file
    lacks join it in the same way.
    """

    def __init__(self, spec: CaptureSpec, folder: Path, names: frozenset[str]) -> None:
        self.spec, self.path, self._names = spec, folder / spec.file_name, names
        self.parts = folder / f"{spec.file_name}.clips"
        self._lock = folder / f".{spec.file_name}.lock"

    def missing(self) -> frozenset[str]:
        """The buffers that the file lacks.

        Raises:
            UserError: the file is truncated, or holds something else than its name says.
        """
        if not self.path.exists():
            return self._names
        store = DatasetFile(self.path)
        held, buffers = store.spec, store.buffers
        store.close()
        if held != self.spec:
            raise UserError(f"{self.path} holds {held.to_json()}, which is not what its name says: remove the file.")
        return self._names - buffers

    def waiting(self) -> list[int]:
        """The clips that are still to be made."""
        missing = self.missing()
        return [k for k in range(self.spec.clips) if not self._has(k, missing)] if missing else []

    def work(self, write: WriteClip, attributes: Mapping[str, str]) -> None:
        """Make every clip that no other process is at, and join them if all are there.

        ``write(clip, writer, names)`` writes all frames of those buffers; what it notes of a clip, and ``attributes``, become
        the file's.

        Raises:
            UserError: the folder cannot be written.
        """
        if self.missing():
            try:
                self.parts.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise UserError(
                    f"Cannot make the folder {self.parts}: {error.strerror}. Set paths.data to another one."
                ) from error
        for clip in self.waiting():
            self._make(clip, write)
        if not self.waiting():
            self._join(attributes)

    def _part(self, clip: int) -> Path:
        return self.parts / f"{clip:04d}.h5"

    def _has(self, clip: int, names: frozenset[str]) -> bool:
        try:
            return names <= buffers_in(self._part(clip))
        except FileNotFoundError:  # another process has just finished the file
            return False

    def _make(self, clip: int, write: WriteClip) -> None:
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
        """How many frames of a clip have each of these buffers."""
        spec = self.spec
        return {n: spec.targets if BUFFERS[n].resolution == "high" else spec.frames for n in sorted(names)}

    def _join(self, attributes: Mapping[str, str]) -> None:
        with FileLock(self._lock):
            missing = self.missing()
            if missing:
                parts = [self._part(k) for k in range(self.spec.clips)]
                with h5py.File(parts[0], "r") as first:
                    noted = {str(key): str(value) for key, value in first.attrs.items()}
                join_clips(self.path, self.spec, parts, missing, noted | dict(attributes))
        if self.parts.exists():
            shutil.rmtree(self.parts, ignore_errors=True)
