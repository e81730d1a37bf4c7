"""A glTF 2.0 file as pygltflib's objects, and the bytes that it refers to, only from inside its folder.

Specification: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (container: section 4; URIs: 2.8 and 3.6.1).
"""

import base64
import binascii
import json
import re
import struct
import warnings
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

from pygltflib import GLTF2

from supersampling.errors import UserError
from supersampling.scenes.gltf.features import SUPPORTED
from supersampling.scenes.gltf.schema import check_types

_MAGIC, _JSON, _BIN = b"glTF", 0x4E4F534A, 0x004E4942
_LARGEST = 1 << 32  # bytes of a file that is read

# Errors of pygltflib and of this reader for malformed files, besides `UserError`. LookupError: KeyError and IndexError.
MALFORMED = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError, struct.error)


def malformed(name: str, error: Exception) -> UserError:
    """Return the error for a broken file that no specific message covers."""
    reason = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    return UserError(f"{name} is not a valid glTF 2.0 file ({reason}): check it with the Khronos glTF validator.")


class Document:
    """Parsed file ``gltf`` with its ``asset`` and ``extensions`` as JSON; buffers and images are read on first use.

    Raises:
        UserError: The file is missing, is not glTF 2, is truncated, or requires an unknown extension.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.name
        self._folder = path.parent
        self.buffer = cache(self._read_buffer)
        text, self._blob = _container(path)
        head = _head(text, self.name)
        _check_version(head, self.name)
        unknown = sorted(set(head.get("extensionsRequired") or ()) - SUPPORTED)
        if unknown:
            raise UserError(
                f"{self.name} requires the unsupported glTF extension {unknown[0]}: export it without "
                f"(supported: {', '.join(sorted(SUPPORTED))})."
            )
        check_types(head, self.name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # about null where a value is expected, which reads as none
            self.gltf: Any = GLTF2.from_json(text, infer_missing=True)
        # From the JSON: pygltflib names itself as the generator of a file without one.
        self.asset: dict[str, Any] = head["asset"]
        self.extensions: dict[str, Any] = head.get("extensions") or {}
        self._head = head

    def item(self, kind: str, index: int | None) -> Any:
        """Return ``gltf.<kind>[index]``, or raise `UserError` if it does not exist."""
        items = getattr(self.gltf, kind)
        if index is None or not 0 <= index < len(items):
            raise UserError(
                f"{self.name} refers to {kind}[{index}] but has {len(items)} {kind}: "
                "the file is broken, export it again."
            )
        return items[index]

    def weights(self, node: int) -> tuple[float, ...] | None:
        """Return a node's weights of morph targets, which pygltflib drops; None if the node has none."""
        weights = self._head["nodes"][node].get("weights")
        return None if weights is None else tuple(float(w) for w in weights)

    def used_extensions(self) -> set[str]:
        """Return the names of the extensions that the file lists or uses."""
        names, waiting = set(self._head.get("extensionsUsed") or ()), [self._head]
        while waiting:
            item = waiting.pop()
            names |= set(item.get("extensions") or ())
            values = [value for key, value in item.items() if key != "extras"]
            lists = [value for value in values if isinstance(value, list)]
            waiting += [value for part in (values, *lists) for value in part if isinstance(value, dict)]
        return names

    def _read_buffer(self, index: int) -> memoryview:
        """Return a buffer's bytes, exactly as many as it declares."""
        declared = self.item("buffers", index)
        length = declared.byteLength or 0
        if declared.uri is None:
            if index != 0 or self._blob is None:
                raise UserError(f"Buffer {index} of {self.name} has neither a uri nor a binary chunk: export it again.")
            data = self._blob
        else:
            data = memoryview(self.resource(declared.uri, f"buffer {index}"))
        if not 0 < length <= len(data):
            raise UserError(
                f"Buffer {index} of {self.name} has {len(data)} bytes instead of {length}: the file is cut short, "
                "copy or export it again."
            )
        return data[:length]

    def view(self, index: int) -> tuple[memoryview, int | None]:
        """Return the bytes and the stride of a buffer view."""
        view = self.item("bufferViews", index)
        data, start, length = self.buffer(view.buffer), view.byteOffset or 0, view.byteLength or 0
        if start < 0 or length <= 0 or start + length > len(data):
            raise UserError(
                f"Buffer view {index} of {self.name} ends at byte {start + length} of a buffer of {len(data)} bytes: "
                "the file is broken, export it again."
            )
        return data[start : start + length], view.byteStride

    def resource(self, uri: str, what: str) -> bytes:
        """Return the bytes of a data URI, or of a file in the glTF file's folder or below."""
        if uri[:5].lower() == "data:":
            return _decode_data_uri(uri, what, self.name)
        return _local_path(self._folder, uri, what, self.name).read_bytes()


def _container(path: Path) -> tuple[str, memoryview | None]:
    """Return the JSON text and the binary chunk."""
    if not path.is_file():
        raise UserError(f"Missing glTF file {path}: use path=FILE.gltf or path=FILE.glb.")
    if path.stat().st_size > _LARGEST:
        raise UserError(f"{path.name} is larger than {_LARGEST >> 30} GB: split it into smaller files.")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"Cannot read {path} ({error.strerror}): check the file and its permissions.") from error
    text, blob = _chunks(data, path.name) if data[:4] == _MAGIC else (data, None)
    try:
        return text.decode("utf-8-sig"), blob
    except UnicodeDecodeError as error:
        raise UserError(f"{path.name} is neither JSON text nor a GLB container: use a glTF 2.0 file.") from error


def _chunks(data: bytes, name: str) -> tuple[bytes, memoryview | None]:
    short = UserError(f"{name} is a GLB file that is cut short at {len(data)} bytes: copy or export it again.")
    if len(data) < 20:
        raise short
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise UserError(f"{name} is a GLB file of unsupported version {version}: export it as glTF 2.0.")
    if length > len(data):
        raise short
    chunks: dict[int, memoryview] = {}
    start, view = 12, memoryview(data)
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        if start + 8 + size > length:
            raise short
        chunks.setdefault(kind, view[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON not in chunks:
        raise UserError(f"{name} is a GLB file without a JSON chunk: export it again.")
    return bytes(chunks[_JSON]), chunks.get(_BIN)


def _head(text: str, name: str) -> dict[str, Any]:
    def refuse(constant: str) -> float:
        raise ValueError(f"{constant} is not a JSON number")

    try:
        head = json.loads(text, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise UserError(f"{name} is not a glTF file, its JSON is invalid ({error}): export it again.") from error
    if not isinstance(head, dict) or not isinstance(head.get("asset"), dict):
        raise UserError(f"{name} is not a glTF file, its JSON has no asset object: export it again.")
    return head


def _check_version(head: dict[str, Any], name: str) -> None:
    version = str(head["asset"].get("version"))
    least = str(head["asset"].get("minVersion", "2.0"))
    if not re.fullmatch(r"2\.\d+", version):
        raise UserError(f"{name} is glTF of unsupported version {version}: export it as glTF 2.0.")
    if least != "2.0":
        raise UserError(f"{name} requires a reader of glTF {least} or newer: export it as glTF 2.0.")


def _decode_data_uri(uri: str, what: str, name: str) -> bytes:
    """Decode ``data:[type][;base64],data`` (RFC 2397)."""
    kind, comma, payload = uri[5:].partition(",")
    try:
        if not comma:
            raise ValueError("it has no comma")
        if kind.lower().endswith(";base64"):
            return base64.b64decode(unquote(payload), validate=True)
        return unquote_to_bytes(payload)
    except (ValueError, binascii.Error) as error:
        raise UserError(f"The data URI of {what} in {name} cannot be decoded ({error}): export it again.") from error


def _local_path(folder: Path, uri: str, what: str, name: str) -> Path:
    """Return the file of a relative URI; symbolic links are resolved before its location is checked."""
    relative = unquote(uri)
    outside = UserError(
        f"The uri {uri} of {what} in {name} leaves the file's folder: put it beside {name} and use a relative uri."
    )
    # A scheme (or a drive), an absolute path, or another system's separators.
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]*:", relative) or relative.startswith(("/", "\\")):
        raise outside
    missing = UserError(f"{name} needs the missing file {relative!r} as {what}: put it beside {name}.")
    if "\0" in relative:
        raise missing
    root = folder.resolve()
    target = (root / relative.replace("\\", "/")).resolve()
    if not target.is_relative_to(root):
        raise outside
    if not target.is_file():
        raise missing
    if target.stat().st_size > _LARGEST:
        raise UserError(f"The file {relative!r} of {name} is larger than {_LARGEST >> 30} GB: split it.")
    return target
