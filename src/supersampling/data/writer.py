"""Writer of data set files: clip by clip in bounded memory, resumable, never half-written, equal content for equal
frames.

Each clip is a small HDF5 file until all clips are finished. Then their compressed chunks are copied unchanged into one
file, which is renamed to its final name. Buffers that are requested later are added to a finished file in the same way.
"""

import errno
import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import product
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supersampling.data.content import DIGEST, digest_of_attributes, read_text, write_text
from supersampling.data.dataset_file import describe
from supersampling.data.hdf5 import MissingFile, errno_of, open_hdf5, reading
from supersampling.data.output import OutputFile
from supersampling.data.spec import CaptureSpec
from supersampling.errors import DamagedFile, UserError, describe_system_error
from supersampling.files import replace_file
from supersampling.frames import BUFFERS

VERSION = "v110"  # of HDF5's format: the first whose structures have checksums
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


_FULL = (errno.ENOSPC, errno.EDQUOT)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        code = errno_of(error)
        condition = describe_system_error(OSError(code, ""), path) if code and code not in _FULL else None
        if condition is not None:
            raise condition from error
        reason = os.strerror(code) if code else error
        raise UserError(
            f"Cannot write {path} ({reason}): free some space, then run again; finished clips are kept."
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
        with _writing(path):
            self._output = OutputFile(self._temporary)
        self._file = h5py.File(self._output, "w", libver=VERSION)

    def add(self, name: str, values: NDArray[np.float32]) -> None:
        """Write the next frame of a buffer, ``(h, w, C)`` float32 in its range (``(2,)`` for jitter)."""
        stored = quantise(name, np.asarray(values))
        with _writing(self._path):
            if self._next[name] == 0:
                self._create(name, stored)
            self._file[name][self._next[name]] = stored
            self._output.check()
        self._hashes[name].update(np.ascontiguousarray(stored).tobytes())
        self._next[name] += 1

    def _create(self, name: str, first: NDArray[Any]) -> None:
        shape, storage = (self._lengths[name], *first.shape), _storage(first.shape, first.dtype)
        self._file.create_dataset(name, shape, first.dtype, track_times=False, **storage)

    def note(self, **attributes: str) -> None:
        """Set attributes of the whole clip."""
        for key, value in attributes.items():
            write_text(self._file, key, value)

    def close(self) -> None:
        assert self._next == self._lengths, (self._next, self._lengths)
        for name, digest in self._hashes.items():
            write_text(self._file[name], DIGEST, digest.hexdigest())
        with _writing(self._path):
            self._close_output()
            replace_file(self._temporary, self._path)

    def _close_output(self) -> None:
        """Close the file; raise `OSError` if not all of it could be written."""
        with self._output:
            self._file.close()
            self._output.check()

    def __enter__(self) -> "ClipWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if error is None:
                self.close()
        finally:
            if not self._output.closed:
                with suppress(OSError):  # of a full disk, which is reported already
                    self._close_output()
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
    """Return the buffers of a finished clip; none if the file does not exist or is broken.

    Raises:
        UserError: the file cannot be opened.
    """
    try:
        with open_hdf5(path) as file, reading(path, "its buffers"):
            return frozenset(name for name in file if DIGEST in file[name].attrs)
    except (MissingFile, DamagedFile):
        return frozenset()


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
        with _writing(path), OutputFile(temporary) as output, h5py.File(output, "w", libver=VERSION) as file:
            if path.exists():
                with open_hdf5(path) as old, reading(path, "a buffer"):
                    for name in sorted(old.keys()):
                        old.copy(old[name], file, name)
                        write_text(file[name], DIGEST, read_text(old[name], DIGEST))
            for name in sorted(names - frozenset(file.keys())):
                _join(file, name, parts)
            texts = {"spec": spec.to_json(), "conventions": describe(sorted(file.keys())), **attributes}
            digests = {name: read_text(file[name], DIGEST) for name in file}
            for key, value in sorted({**texts, DIGEST: digest_of_attributes(texts, digests)}.items()):
                write_text(file, key, value)
            file.close()
            output.check()
        with _writing(path):
            replace_file(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _join(file: h5py.File, name: str, parts: Sequence[Path]) -> None:
    """Stack a buffer of the clips; its digest is that of the clips' digests in order."""
    digest = hashlib.sha256()
    stacked: h5py.Dataset | None = None
    for clip, part in enumerate(parts):
        with open_hdf5(part) as source, reading(part, name):
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
            digest.update(read_text(data, DIGEST).encode())
    assert stacked is not None
    write_text(stacked, DIGEST, digest.hexdigest())


def _copy_chunks(source: h5py.Dataset, target: h5py.Dataset, clip: int) -> None:
    """Copy compressed chunks unchanged: the same tile of the same frame has the same bytes in both files."""
    # Every chunk exists. Looking up the k-th chunk instead would scan the index from its start each time.
    for offset in product(*(range(0, n, c) for n, c in zip(source.shape, source.chunks))):
        mask, data = source.id.read_direct_chunk(offset)
        target.id.write_direct_chunk((clip, *offset), data, mask)
