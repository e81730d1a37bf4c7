"""Writer of data set files: clip by clip in bounded memory, resumable, never half-written, equal content for equal
frames.

Each clip is a small HDF5 file until all clips are finished. Then their compressed chunks are copied unchanged into one
file, which is renamed to its final name. Buffers that are requested later are added to a finished file in the same way.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supersampling.data.dataset_file import describe
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.frames import BUFFERS

TILE = 64  # pixels; a 64 x 64 target crop touches at most four tiles
HALF_MAX = 65504.0


def quantise(name: str, values: NDArray[np.float32]) -> NDArray[Any]:
    """Return a buffer in its stored type: [0, 1] to 8 bits rounded to nearest, half floats clamped to their range."""
    dtype = BUFFERS[name].dtype
    if dtype == "uint8":
        return np.round(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
    if dtype == "float16":
        return np.clip(values, -HALF_MAX, HALF_MAX).astype(np.float16)
    return values.astype(dtype)


@contextmanager
def _no_space(path: Path) -> Iterator[None]:
    try:
        yield
    # h5py raises RuntimeError if a flush fails.
    except (OSError, RuntimeError) as error:
        raise UserError(
            f"Cannot write {path} ({getattr(error, 'strerror', None) or error}): free some space, then run again; "
            "finished "
            "clips are kept."
        ) from error


class ClipWriter:
    """Writer of one clip, frame by frame, to a temporary file that `close` renames to ``path``; a context manager.

    ``lengths`` is the number of frames of each buffer. An error inside the context removes the temporary file.

    Raises:
        UserError: the disk is full or the folder cannot be written.
    """

    def __init__(self, path: Path, lengths: Mapping[str, int]) -> None:
        self._path, self._lengths = path, dict(lengths)
        self._temporary = path.with_suffix(".tmp")
        self._next = dict.fromkeys(lengths, 0)
        self._hashes = {name: hashlib.sha256() for name in lengths}
        with _no_space(path):
            self._file = h5py.File(self._temporary, "w", libver="v110")

    def add(self, name: str, values: NDArray[np.float32]) -> None:
        """Write the next frame of a buffer, ``(h, w, C)`` float32 in its range (``(2,)`` for jitter)."""
        stored = quantise(name, np.asarray(values))
        with _no_space(self._path):
            if self._next[name] == 0:
                self._create(name, stored)
            self._file[name][self._next[name]] = stored
        self._hashes[name].update(np.ascontiguousarray(stored).tobytes())
        self._next[name] += 1

    def _create(self, name: str, first: NDArray[Any]) -> None:
        shape, storage = (self._lengths[name], *first.shape), _storage(first.shape, first.dtype)
        self._file.create_dataset(name, shape, first.dtype, track_times=False, **storage)

    def note(self, **attributes: str) -> None:
        """Set attributes of the whole clip."""
        for key, value in attributes.items():
            self._file.attrs[key] = value

    def close(self) -> None:
        assert self._next == self._lengths, (self._next, self._lengths)
        with _no_space(self._path):
            for name, digest in self._hashes.items():
                self._file[name].attrs["digest"] = digest.hexdigest()
            self._file.close()
            self._temporary.replace(self._path)

    def __enter__(self) -> "ClipWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        try:
            self._file.close()
        finally:
            self._temporary.unlink(missing_ok=True)


def _storage(frame: tuple[int, ...], dtype: np.dtype) -> dict[str, Any]:
    """Return HDF5 options: compressed chunks of one frame's tile; wider types are shuffled, which halves smooth
    buffers."""
    if len(frame) == 1:
        return {}
    height, width, channels = frame
    chunks = (1, min(TILE, height), min(TILE, width), channels)
    return {"chunks": chunks, "compression": "gzip", "compression_opts": 1, "shuffle": dtype.itemsize > 1}


def buffers_in(path: Path) -> frozenset[str]:
    """Return the buffers of a finished clip or data set file; none if the file does not exist."""
    if not path.exists():
        return frozenset()
    with h5py.File(path, "r") as file:
        return frozenset(file.keys())


def join_clips(
    path: Path, spec: CaptureSpec, parts: Sequence[Path], names: frozenset[str], attributes: Mapping[str, str]
) -> None:
    """Write the buffers ``names`` to the data set ``path`` from one file per clip; buffers already in ``path`` remain.

    A temporary file is written and renamed. Equal clips give equal bytes: times are not tracked, the order is fixed.

    Raises:
        UserError: the disk is full or the folder cannot be written.
    """
    temporary = path.with_suffix(".h5.part")
    try:
        with _no_space(path), h5py.File(temporary, "w", libver="v110") as file:
            if path.exists():
                with h5py.File(path, "r") as old:
                    for name in sorted(old.keys()):
                        old.copy(old[name], file, name)
            for name in sorted(names - frozenset(file.keys())):
                _join(file, name, parts)
            file.attrs["spec"] = spec.to_json()
            file.attrs["conventions"] = describe(sorted(file.keys()))
            for key, value in sorted(attributes.items()):
                file.attrs[key] = value
        with _no_space(path):
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _join(file: h5py.File, name: str, parts: Sequence[Path]) -> None:
    """Stack a buffer of the clips; its digest is that of the clips' digests in order."""
    digest = hashlib.sha256()
    stacked: h5py.Dataset | None = None
    for clip, part in enumerate(parts):
        with h5py.File(part, "r") as source:
            data = source[name]
            if stacked is None:
                shape = (len(parts), *data.shape)
                storage = _storage(data.shape[1:], data.dtype)
                if storage:
                    storage["chunks"] = (1, *storage["chunks"])
                stacked = file.create_dataset(name, shape, data.dtype, track_times=False, **storage)
            if data.chunks is None:
                stacked[clip] = data[()]
            else:
                _copy_chunks(data, stacked, clip)
            digest.update(str(data.attrs["digest"]).encode())
    assert stacked is not None
    stacked.attrs["digest"] = digest.hexdigest()


def _copy_chunks(source: h5py.Dataset, target: h5py.Dataset, clip: int) -> None:
    """Copy compressed chunks unchanged: the same tile of the same frame has the same bytes in both files."""
    # Every chunk exists. Looking up the k-th chunk instead would scan the index from its start each time.
    for offset in product(*(range(0, n, c) for n, c in zip(source.shape, source.chunks))):
        mask, data = source.id.read_direct_chunk(offset)
        target.id.write_direct_chunk((clip, *offset), data, mask)
