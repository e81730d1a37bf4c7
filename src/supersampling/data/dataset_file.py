"""Reader of data set files: one HDF5 file per scene and split, laid out for reading random windows of random clips.

Every image buffer is ``(clips, frames, height, width, channels)`` in chunks of one frame's tile, gzip-compressed;
``jitter`` is ``(clips, frames, 2)``. A file holds the requested buffers; high-resolution buffers, which cost the most,
may exist for the last frames of each clip only. The attributes state the conventions of the arrays: see `describe`.
"""

import hashlib
import json
from collections.abc import Iterable
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supersampling.data.content import buffer_shape, check_digest, read_content
from supersampling.data.handles import Handle, changed
from supersampling.data.hdf5 import HDF5_ERRORS, explain
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.frames import BUFFERS


def describe(names: Iterable[str]) -> str:
    """Return the conventions of these buffers as JSON, which every file stores."""
    keys = ("channels", "resolution", "dtype", "unit", "range")
    return json.dumps({name: {k: getattr(BUFFERS[name], k) for k in keys} for name in names}, sort_keys=True)


def restore(name: str, stored: NDArray[Any]) -> NDArray[np.float32]:
    """Return a stored buffer as float32 in its range."""
    if BUFFERS[name].dtype == "uint8":
        return stored.astype(np.float32) * np.float32(1.0 / 255.0)
    return stored.astype(np.float32, copy=False)


class DatasetFile:
    """A data set file, read-only. It is open while it is read; it can be pickled, and closed files are opened again.

    Raises:
        DamagedFile: the file is truncated or not HDF5, or its content is not the one that was written.
        UserError: the file is missing or cannot be opened, or is not a data set.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self._handle = Handle(self.path)
        self._loaded: dict[str, NDArray[Any]] = {}
        self._jitter_checked = False
        file, _ = self._handle.open()
        try:
            self._content = read_content(self.path, file)
        except UserError:
            self._handle.close()
            raise
        self.spec = self._content.spec

    def __reduce__(self) -> tuple[type["DatasetFile"], tuple[Path]]:
        """Pickle the path: another process opens the file itself."""
        return DatasetFile, (self.path,)

    @property
    def buffers(self) -> frozenset[str]:
        """Return the names of the buffers in the file."""
        return frozenset(self._content.digests)

    def fingerprint(self, names: Iterable[str]) -> str:
        """Return 16 hex digits that depend only on the content of these buffers and on the specification."""
        digests = {name: self._content.digests[name] for name in names}
        content = json.dumps([self.spec.to_json(), digests], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    @property
    def attributes(self) -> dict[str, str]:
        """Return renderer, software version, attribution and all other attributes, as text."""
        return dict(self._content.attributes)

    @property
    def clips(self) -> int:
        return self.spec.clips

    def read(
        self, name: str, clip: int, frames: slice, window: tuple[int, int, int, int] | None = None
    ) -> NDArray[np.float32]:
        """Return frames of a buffer, ``(T, C, h, w)`` (``(T, 2)`` for jitter), float32 in its range.

        ``frames`` counts from the clip's first frame; high-resolution buffers exist for the last ``spec.targets``
        frames. ``window`` is ``(x, y, width, height)`` in pixels of the buffer. Motion is in units of the *returned*
        image, so that ``previous_uv = uv + motion`` also holds in a crop.
        """
        first, stop, _ = frames.indices(self.spec.frames)
        offset = self.spec.frames - self.spec.targets if BUFFERS[name].resolution == "high" else 0
        assert first >= offset, f"{self.path} has {name} of the last {self.spec.targets} frames only"
        frames = slice(first - offset, stop - offset)
        if BUFFERS[name].resolution == "frame":
            return restore(name, self._stored(name, clip, (frames,)))
        height, width = buffer_shape(name, self.spec)[2:4]
        x, y, w, h = window if window is not None else (0, 0, width, height)
        values = restore(name, self._stored(name, clip, (frames, slice(y, y + h), slice(x, x + w))))
        if BUFFERS[name].kind == "plane":
            values = values * np.array((width / w, height / h), dtype=np.float32)
        return np.ascontiguousarray(values.transpose(0, 3, 1, 2))

    def size(self, names: Iterable[str]) -> int:
        """Return the size of these buffers in memory, in bytes."""
        return sum(prod(buffer_shape(name, self.spec)) * np.dtype(BUFFERS[name].dtype).itemsize for name in names)

    def load(self, names: Iterable[str]) -> None:
        """Load whole buffers into memory: a window then costs a copy instead of a read and a decompression per
        frame."""
        loaded: dict[str, NDArray[Any]] = {}
        for name in names:
            loaded[name] = np.empty(buffer_shape(name, self.spec), BUFFERS[name].dtype)
            for clip in range(self.clips):
                loaded[name][clip] = self._stored(name, clip, (slice(None),))
        self._loaded = loaded

    def _stored(self, name: str, clip: int, part: tuple[slice, ...]) -> NDArray[Any]:
        """Return a part of a clip of a buffer as it is stored; ``part`` is ``(frames,)`` or ``(frames, y, x)``.

        Raises:
            UserError: it cannot be read; the message names buffer, clip and frame.
        """
        if name not in self.buffers:
            raise UserError(f"{self.path} has no {name}: render or import it with buffers=[{name}].")
        if name in self._loaded:
            return self._loaded[name][clip][part]
        file = self._open()
        if BUFFERS[name].resolution == "frame" and not self._jitter_checked:
            check_digest(self.path, file, name, self._content.digests[name])
            self._jitter_checked = True
        place: Any = (clip, *part)
        try:
            values: NDArray[Any] = file[name][place]
            return values
        except HDF5_ERRORS as error:
            first, stop, _ = part[0].indices(buffer_shape(name, self.spec)[1])
            offset = self.spec.frames - buffer_shape(name, self.spec)[1]
            bad = next((t for t in range(first, stop) if not _can_read(file, name, (clip, t, *part[1:]))), first)
            raise explain(self.path, error, f"{name} of clip {clip}, frame {bad + offset}") from error

    def _open(self) -> h5py.File:
        """Return the open file; one that was closed meanwhile must have the same content when it is opened again."""
        file, new = self._handle.open()
        if new and not self._content.is_part_of(read_content(self.path, file)):
            self._handle.close()
            raise changed(self.path)
        return file

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_loaded": {}}

    def close(self) -> None:
        self._handle.close()


def _can_read(file: h5py.File, name: str, place: tuple[int | slice, ...]) -> bool:
    try:
        file[name][place]
    except HDF5_ERRORS:
        return False
    return True


def read_spec(path: Path) -> CaptureSpec:
    """Return the specification of a data set file."""
    file = DatasetFile(path)
    file.close()
    return file.spec
