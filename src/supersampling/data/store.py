"""One HDF5 file a scene and split: laid out so that a random window of a random clip reads little else.

Every image buffer is ``(clips, frames, height, width, channels)`` in chunks of one frame's tile, gzip-compressed; ``jitter``
is ``(clips, frames, 2)``. Targets cost the most, so a file may hold them for each clip's last frames only. The attributes
hold all that is needed to trust the arrays: see `describe`.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supersampling.data.spec import SCHEMA_VERSION, CaptureSpec
from supersampling.errors import UserError
from supersampling.frames import BUFFERS

TILE = 64  # pixels; a 64 x 64 target crop touches at most four tiles
ClipArrays = Mapping[str, NDArray[Any]]


def describe() -> str:
    """The conventions of every buffer as JSON, stored in each file."""
    keys = ("channels", "resolution", "dtype", "unit", "range")
    return json.dumps({name: {k: getattr(b, k) for k in keys} for name, b in BUFFERS.items()}, sort_keys=True)


def quantise(name: str, values: NDArray[np.float32]) -> NDArray[Any]:
    """A rendered buffer in its stored type: [0, 1] to 8 bits rounded to nearest, the others unchanged."""
    if BUFFERS[name].dtype == "uint8":
        return np.round(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
    return values.astype(BUFFERS[name].dtype)


def restore(name: str, stored: NDArray[Any]) -> NDArray[np.float32]:
    """A stored buffer as float32 in its range."""
    if BUFFERS[name].dtype == "uint8":
        return stored.astype(np.float32) * np.float32(1.0 / 255.0)
    return stored.astype(np.float32, copy=False)


def write_file(path: Path, spec: CaptureSpec, clips: list[ClipArrays], attributes: Mapping[str, str]) -> None:
    """Write a whole file beside ``path`` and rename it there, so that ``path`` is never half-written.

    Equal arguments give equal bytes: times are not tracked and the order of creation is fixed.

    Raises:
        UserError: the disk is full or the folder cannot be written.
    """
    beside = path.with_suffix(".h5.part")
    try:
        with h5py.File(beside, "w", libver="v110") as file:
            for name in sorted(clips[0]):
                stacked = np.stack([clip[name] for clip in clips])
                if BUFFERS[name].resolution == "frame":
                    file.create_dataset(name, data=stacked, track_times=False)
                    continue
                height, width = stacked.shape[2:4]
                chunks = (1, 1, min(TILE, height), min(TILE, width), stacked.shape[-1])
                file.create_dataset(
                    name,
                    data=stacked,
                    chunks=chunks,
                    compression="gzip",
                    compression_opts=1,
                    track_times=False,
                )
            file.attrs["spec"] = spec.to_json()
            file.attrs["conventions"] = describe()
            for key, value in sorted(attributes.items()):
                file.attrs[key] = value
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise UserError(
            f"Cannot write the data set {path}: {error.strerror or error}. Free some space, then run again."
        ) from error


class Store:
    """An open data set file, read only.

    Raises:
        UserError: the file is missing, truncated, not HDF5, or not one of ours.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = h5py.File(path, "r")
        except FileNotFoundError as error:
            raise UserError(f"There is no data set {path}: run render.py, or correct the path.") from error
        except OSError as error:
            raise UserError(
                f"{path} is truncated or not an HDF5 file: delete it, and it will be rendered again."
            ) from error
        self._held: dict[str, NDArray[Any]] = {}
        self.spec = self._read_spec()
        self.fingerprint = str(self._file.attrs["fingerprint"])

    def _read_spec(self) -> CaptureSpec:
        try:
            fields = json.loads(str(self._file.attrs["spec"]))
            schema = fields.pop("schema")
            for key in ("frame", "window"):
                fields[key] = tuple(fields[key])
            spec = CaptureSpec(**fields)
            if schema != SCHEMA_VERSION or "fingerprint" not in self._file.attrs:
                raise ValueError(schema)
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            self._file.close()
            raise UserError(
                f"{self.path} is an HDF5 file, but not a data set of schema {SCHEMA_VERSION} written by "
                "render.py."
            ) from error
        return spec

    @property
    def attributes(self) -> dict[str, str]:
        """Renderer, software version, attribution and the rest, as text."""
        return {key: str(value) for key, value in self._file.attrs.items()}

    @property
    def clips(self) -> int:
        return self.spec.clips

    def read(
        self, name: str, clip: int, frames: slice, window: tuple[int, int, int, int] | None = None
    ) -> NDArray[np.float32]:
        """A buffer's frames, ``(T, C, h, w)`` (``(T, 2)`` for jitter), float32 in its range.

        ``frames`` counts from the clip's first frame; targets can be read where the file has them (``spec.targets``).
        ``window`` is ``(x, y, width, height)`` in the buffer's own pixels. Motion stays in units of the *returned* image,
        so that ``previous_uv = uv + motion`` holds in a crop as it does in the whole.
        """
        data = self._held.get(name, self._file[name])
        first, stop, _ = frames.indices(self.spec.frames)
        if BUFFERS[name].resolution == "high":
            offset = self.spec.frames - self.spec.targets
            first, stop = first - offset, stop - offset
        frames = slice(first, stop)
        if BUFFERS[name].resolution == "frame":
            return restore(name, data[clip, frames])
        height, width = data.shape[2:4]
        x, y, w, h = window if window is not None else (0, 0, width, height)
        values = restore(name, data[clip, frames, y : y + h, x : x + w])
        if name == "motion":
            values = values * np.array((width / w, height / h), dtype=np.float32)
        return np.ascontiguousarray(values.transpose(0, 3, 1, 2))

    def size(self, names: Iterable[str]) -> int:
        """Bytes that these buffers take in memory."""
        return sum(self._file[name].nbytes for name in names)

    def hold(self, names: Iterable[str]) -> None:
        """Keep whole buffers in memory: a window then costs a copy instead of a read and a decompression a frame."""
        self._held = {name: self._file[name][()] for name in names}

    def close(self) -> None:
        self._file.close()


def spec_of(path: Path) -> CaptureSpec:
    """What a file says that it holds."""
    store = Store(path)
    store.close()
    return store.spec
