"""The content of a data set file: a specification, and buffers of the shapes and types that follow from it."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from supersampling.data.hdf5 import RESTORE, reading
from supersampling.data.spec import SCHEMA_VERSION, CaptureSpec
from supersampling.errors import DamagedFile, UserError
from supersampling.frames import BUFFERS

DIGEST = "digest"  # of a buffer's values; of all attributes and digests, at the file itself


@dataclass(frozen=True)
class Content:
    """The specification of a file, its attributes as text, and the digest of each buffer by name."""

    spec: CaptureSpec
    attributes: Mapping[str, str]
    digests: Mapping[str, str]

    def is_part_of(self, content: "Content") -> bool:
        """Return whether another state of the file has the same buffers, and perhaps more."""
        return self.spec == content.spec and self.digests.items() <= content.digests.items()


def buffer_shape(name: str, spec: CaptureSpec) -> tuple[int, ...]:
    """Return the stored shape of a buffer: ``(clips, frames, height, width, channels)``, or ``(clips, frames, 2)``."""
    buffer = BUFFERS[name]
    frames = spec.targets if buffer.resolution == "high" else spec.frames
    if buffer.resolution == "frame":
        return spec.clips, frames, buffer.channels
    width, height = spec.target_size if buffer.resolution == "high" else (n // spec.scale for n in spec.target_size)
    return spec.clips, frames, height, width, buffer.channels


def write_text(item: h5py.HLObject, key: str, text: str) -> None:
    """Set an attribute of fixed length: HDF5 has no checksum for texts of variable length, and damage to one can make
    it loop without end.
    """
    content = text.encode()
    item.attrs.create(key, content, dtype=h5py.string_dtype("utf-8", max(1, len(content))))


def read_text(item: h5py.HLObject, key: str) -> str:
    """Return an attribute as text; earlier versions wrote texts of variable length."""
    value = item.attrs[key]
    return value.decode() if isinstance(value, bytes) else str(value)


def digest_of_attributes(attributes: Mapping[str, str], digests: Mapping[str, str]) -> str:
    """Return a digest of these attributes and of the buffers' digests, and the names of the attributes.

    HDF5 has no checksum for texts. Attributes that a user adds to a file do not change it.
    """
    text = json.dumps([dict(attributes), dict(digests)], sort_keys=True)
    return " ".join([hashlib.sha256(text.encode()).hexdigest(), *sorted(attributes)])


def read_content(path: Path, file: h5py.File) -> Content:
    """Read and check what a file holds; the values of buffers are not read.

    Raises:
        DamagedFile: the file cannot be read, or its attributes are not those that were written.
        UserError: it is not a data set of this schema, or a buffer has another shape or type than its specification.
    """
    with reading(path, "its attributes"):
        attributes = {str(key): read_text(file, key) for key in file.attrs}
        buffers = {str(name): file[name] for name in file}
        digests = {name: read_text(item, DIGEST) for name, item in buffers.items() if DIGEST in item.attrs}
    spec = _read_spec(path, attributes, buffers)
    for name, item in buffers.items():
        _check_buffer(path, item, name, spec)
    incomplete = sorted(buffers.keys() - digests.keys())
    if incomplete:
        raise UserError(f"{path} has no digest of {incomplete[0]}, so another program wrote this buffer: {RESTORE}.")
    _check_attributes(path, attributes, digests)
    return Content(spec, attributes, digests)


def _read_spec(path: Path, attributes: Mapping[str, str], buffers: Iterable[str]) -> CaptureSpec:
    unknown = sorted(set(buffers) - BUFFERS.keys())
    reason = f"it has {unknown[0]}, which is no buffer" if unknown else ""
    if "spec" not in attributes:
        reason = "it has no specification"
    if not reason:
        try:
            return CaptureSpec.from_json(attributes["spec"])
        except ValueError as error:
            reason = f"its specification has {error}"
    raise UserError(
        f"{path} is an HDF5 file but not a data set of schema {SCHEMA_VERSION} written by render.py ({reason}): name "
        "another file, or render or import it again."
    )


def _check_buffer(path: Path, item: h5py.HLObject, name: str, spec: CaptureSpec) -> None:
    shape, dtype = buffer_shape(name, spec), np.dtype(BUFFERS[name].dtype)
    if not isinstance(item, h5py.Dataset):
        raise UserError(f"{path} has a group called {name} instead of the buffer: {RESTORE}.")
    with reading(path, name):
        stored = item.shape, item.dtype
    if stored != (shape, dtype):
        raise UserError(
            f"{path} has a buffer {name} of shape {stored[0]} and type {stored[1]} instead of {shape} and {dtype}, "
            f"which follow from its specification: {RESTORE}."
        )


def _check_attributes(path: Path, attributes: Mapping[str, str], digests: Mapping[str, str]) -> None:
    """Raise `DamagedFile` if attributes are not those that were written; files of earlier versions have no digest."""
    if DIGEST not in attributes:
        return
    names = attributes[DIGEST].split(" ")[1:]
    written = {name: attributes.get(name, "") for name in names}
    if digest_of_attributes(written, digests) != attributes[DIGEST]:
        reason = f"{path} has attributes that are not those that were written"
        raise DamagedFile(f"{reason}: {RESTORE}.", reason)


def check_digest(path: Path, file: h5py.File, name: str, digest: str) -> None:
    """Raise `DamagedFile` if the values of a buffer are not those that were written; this reads the whole buffer."""
    hashes = hashlib.sha256()
    with reading(path, name):
        for clip in range(len(file[name])):
            hashes.update(hashlib.sha256(file[name][clip].tobytes()).hexdigest().encode())
    if hashes.hexdigest() != digest:
        reason = f"{path} is damaged in {name}, whose values are not those that were written"
        raise DamagedFile(f"{reason}: {RESTORE}.", reason)
