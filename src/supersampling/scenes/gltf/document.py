"""A glTF 2.0 file as pygltflib's objects, and the bytes that it refers to, never from outside its folder.

After the specification: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (container: section 4; URIs: 2.8 and 3.6.1).
"""

import base64
import binascii
import json
import re
import struct
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

from pygltflib import GLTF2

from supersampling.errors import UserError

SUPPORTED = frozenset(
    {
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_unlit",
        "KHR_mesh_quantization",
        "KHR_texture_transform",
    }
)
_MAGIC, _JSON, _BIN = b"glTF", 0x4E4F534A, 0x004E4942
_LARGEST = 1 << 32  # bytes of a file that is read

# What a malformed file makes pygltflib and our own reading raise; `UserError` passes.
MALFORMED = (
    ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError, RecursionError, struct.error,
)  # fmt: skip


def malformed(name: str, error: Exception) -> UserError:
    """What to say of a file whose structure is broken in a way that has no sentence of its own."""
    reason = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    return UserError(f"{name} is not a valid glTF 2.0 file ({reason}): check it with the Khronos glTF validator.")


class Document:
    """``gltf`` is the parsed file, ``asset`` and ``extensions`` its JSON; buffers and images are read when asked for.

    Raises:
        UserError: no such file, no glTF, another version than 2, a truncated GLB, or an extension that is required and unknown.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.name
        self._folder = path.parent
        self.buffer = cache(self._buffer)
        text, self._blob = _container(path)
        head = _head(text, self.name)
        _check_version(head, self.name)
        unknown = sorted(set(head.get("extensionsRequired") or ()) - SUPPORTED)
        if unknown:
            raise UserError(
                f"{self.name} requires the glTF extension {unknown[0]}, which is not supported: export it without "
                f"(supported are {', '.join(sorted(SUPPORTED))})."
            )
        self.gltf: Any = GLTF2.from_json(text, infer_missing=True)
        # As they stand: pygltflib names itself as the generator of a file that names none.
        self.asset: dict[str, Any] = head["asset"]
        self.extensions: dict[str, Any] = head.get("extensions") or {}

    def item(self, kind: str, index: int) -> Any:
        """``gltf.<kind>[index]``, or a `UserError` where there is no such one."""
        items = getattr(self.gltf, kind)
        if not 0 <= index < len(items):
            raise UserError(
                f"{self.name} refers to {kind}[{index}], but it has {len(items)} {kind}: the file is broken, export it again."
            )
        return items[index]

    def _buffer(self, index: int) -> memoryview:
        """A buffer's bytes, exactly as many as it declares."""
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
                f"Buffer {index} of {self.name} should have {length} bytes, but {len(data)} are there: the file is cut short, "
                "copy or export it again."
            )
        return data[:length]

    def view(self, index: int) -> tuple[memoryview, int | None]:
        """A buffer view's bytes and its stride."""
        view = self.item("bufferViews", index)
        data, start, length = self.buffer(view.buffer), view.byteOffset or 0, view.byteLength or 0
        if start < 0 or length <= 0 or start + length > len(data):
            raise UserError(
                f"Buffer view {index} of {self.name} ends at byte {start + length} of a buffer of {len(data)} bytes: "
                "the file is broken, export it again."
            )
        return data[start : start + length], view.byteStride

    def resource(self, uri: str, what: str) -> bytes:
        """The bytes of a data URI, or of a file in the glTF file's folder or below it."""
        if uri[:5].lower() == "data:":
            return _inline(uri, what, self.name)
        return _local(self._folder, uri, what, self.name).read_bytes()


def _container(path: Path) -> tuple[str, memoryview | None]:
    """The JSON text and the binary chunk."""
    if not path.is_file():
        raise UserError(f"There is no glTF file {path}: give path=FILE.gltf or path=FILE.glb.")
    if path.stat().st_size > _LARGEST:
        raise UserError(f"{path.name} is larger than {_LARGEST >> 30} GB: split it into smaller files.")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path} cannot be read: {error.strerror}.") from error
    text, blob = _chunks(data, path.name) if data[:4] == _MAGIC else (data, None)
    try:
        return text.decode("utf-8-sig"), blob
    except UnicodeDecodeError as error:
        raise UserError(f"{path.name} is no glTF file: it is neither JSON text nor a GLB container.") from error


def _chunks(data: bytes, name: str) -> tuple[bytes, memoryview | None]:
    short = UserError(f"{name} is a GLB file that is cut short at {len(data)} bytes: copy or export it again.")
    if len(data) < 20:
        raise short
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise UserError(
            f"{name} is a GLB file of version {version}, only version 2 can be read: export it as glTF 2.0."
        )
    if length > len(data):
        raise short
    found: dict[int, memoryview] = {}
    at, view = 12, memoryview(data)
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > length:
            raise short
        found.setdefault(kind, view[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON not in found:
        raise UserError(f"{name} is a GLB file without a JSON chunk: export it again.")
    return bytes(found[_JSON]), found.get(_BIN)


def _head(text: str, name: str) -> dict[str, Any]:
    def refuse(constant: str) -> float:
        raise ValueError(f"{constant} is no JSON number")

    try:
        head = json.loads(text, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise UserError(f"{name} is no glTF file: its JSON cannot be read ({error}).") from error
    if not isinstance(head, dict) or not isinstance(head.get("asset"), dict):
        raise UserError(f"{name} is no glTF file: its JSON has no asset object.")
    return head


def _check_version(head: dict[str, Any], name: str) -> None:
    version = str(head["asset"].get("version"))
    if not re.fullmatch(r"2\.\d+", version):
        raise UserError(f"{name} is glTF version {version}, only version 2 can be read: export it as glTF 2.0.")


def _inline(uri: str, what: str, name: str) -> bytes:
    """RFC 2397: ``data:[type][;base64],data``."""
    kind, comma, payload = uri[5:].partition(",")
    try:
        if not comma:
            raise ValueError("it has no comma")
        if kind.lower().endswith(";base64"):
            return base64.b64decode(unquote(payload), validate=True)
        return unquote_to_bytes(payload)
    except (ValueError, binascii.Error) as error:
        raise UserError(f"The data URI of {what} in {name} cannot be decoded ({error}): export it again.") from error


def _local(folder: Path, uri: str, what: str, name: str) -> Path:
    """The file that a relative URI means; links are followed before its place is judged."""
    relative = unquote(uri)
    outside = UserError(
        f"The uri {uri!r} of {what} in {name} leaves the file's folder: put the file beside {name} and name it relatively."
    )
    # A scheme (or a drive), an absolute path, or another system's separators.
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]*:", relative) or relative.startswith(("/", "\\")):
        raise outside
    missing = UserError(f"{name} needs the file {relative!r} as {what}, which is missing: put it beside {name}.")
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
