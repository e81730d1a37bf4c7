"""Reader of data set files: one HDF5 file per scene and split, laid out for reading random windows of random clips.

Every image buffer is ``(clips, frames, height, width, channels)`` in chunks of one frame's tile, gzip-compressed;
``jitter`` is ``(clips, frames, 2)``. A file holds the requested buffers; high-resolution buffers, which cost the most,
may exist for the last frames of each clip only. The attributes state the conventions of the arrays: see `describe`.
"""

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supersampling.data.spec import SCHEMA_VERSION, CaptureSpec
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
    """An open data set file, read-only.

    Raises:
        UserError: the file is missing, truncated, not HDF5, or not a data set.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = h5py.File(path, "r")
        except FileNotFoundError as error:
            raise UserError(f"Data set {path} not found: run render.py, or correct the path.") from error
        except OSError as error:
            raise UserError(
                f"{path} is truncated or not an HDF5 file: delete it, then it is rendered again."
            ) from error
        self._loaded: dict[str, NDArray[Any]] = {}
        self.spec = self._read_spec()

    def __reduce__(self) -> tuple[type["DatasetFile"], tuple[Path]]:
        """Pickle the path: another process opens the file itself."""
        return DatasetFile, (self.path,)

    @property
    def buffers(self) -> frozenset[str]:
        """Return the names of the buffers in the file."""
        return frozenset(self._file.keys())

    def fingerprint(self, names: Iterable[str]) -> str:
        """Return 16 hex digits that depend only on the content of these buffers and on the specification."""
        digests = {name: str(self._file[name].attrs["digest"]) for name in names}
        content = json.dumps([self.spec.to_json(), digests], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def _read_spec(self) -> CaptureSpec:
        try:
            fields = json.loads(str(self._file.attrs["spec"]))
            schema = fields.pop("schema")
            for key in ("frame", "window"):
                fields[key] = tuple(fields[key])
            spec = CaptureSpec(**fields)
            if schema != SCHEMA_VERSION or not self.buffers <= BUFFERS.keys():
                raise ValueError(schema)
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            self._file.close()
            raise UserError(
                f"{self.path} is an HDF5 file but not a data set of schema {SCHEMA_VERSION} written by "
                "render.py: render or import it again."
            ) from error
        return spec

    @property
    def attributes(self) -> dict[str, str]:
        """Return renderer, software version, attribution and all other attributes, as text."""
        return {key: str(value) for key, value in self._file.attrs.items()}

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
        data = self._loaded.get(name, self._file[name])
        first, stop, _ = frames.indices(self.spec.frames)
        if BUFFERS[name].resolution == "high":
            offset = self.spec.frames - self.spec.targets
            first, stop = first - offset, stop - offset
            assert first >= 0, f"{self.path} has {name} of the last {self.spec.targets} frames only"
        frames = slice(first, stop)
        if BUFFERS[name].resolution == "frame":
            return restore(name, data[clip, frames])
        height, width = data.shape[2:4]
        x, y, w, h = window if window is not None else (0, 0, width, height)
        values = restore(name, data[clip, frames, y : y + h, x : x + w])
        if BUFFERS[name].kind == "plane":
            values = values * np.array((width / w, height / h), dtype=np.float32)
        return np.ascontiguousarray(values.transpose(0, 3, 1, 2))

    def size(self, names: Iterable[str]) -> int:
        """Return the size of these buffers in memory, in bytes."""
        return sum(self._file[name].nbytes for name in names)

    def load(self, names: Iterable[str]) -> None:
        """Load whole buffers into memory: a window then costs a copy instead of a read and a decompression per
        frame."""
        self._loaded = {name: self._file[name][()] for name in names}

    def close(self) -> None:
        self._file.close()


def read_spec(path: Path) -> CaptureSpec:
    """Return the specification of a data set file."""
    file = DatasetFile(path)
    file.close()
    return file.spec
