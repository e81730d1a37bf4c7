"""Builder of small glTF 2.0 files, written by hand from the specification."""

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from supersampling.errors import UserError
from supersampling.render.camera import Camera, Shot, Window
from supersampling.scenes.gltf import load_gltf

TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
# A square of side 2 in the plane z = 0 that faces +z, counter-clockwise from the bottom left, and its texture
# coordinates.
SQUARE = ((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))
SQUARE_UV = ((0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0))
SQUARE_INDICES = (0, 1, 2, 0, 2, 3)


def front_shot(distance: float, width: int, height: int, fov: float = 1.0) -> Shot:
    """Return a still shot along -z from the given distance in front of the origin."""
    view = np.eye(4)
    view[2, 3] = -distance
    camera = Camera(view, fov)
    return Shot(camera, camera, 0.0, 0.0, Window(width, height, 0, 0, width, height))


def png(pixels: Any, kind: str = "PNG") -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(out, kind)
    return out.getvalue()


def data_uri(data: bytes, kind: str = "application/octet-stream") -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


class Builder:
    """File under construction: ``json`` is its JSON, which tests may edit; ``blob`` its only buffer."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}}
        self.blob = b""

    def add(self, kind: str, item: dict[str, Any]) -> int:
        self.json.setdefault(kind, []).append(item)
        return len(self.json[kind]) - 1

    def view(self, data: bytes, **more: Any) -> int:
        self.blob += b"\0" * (-len(self.blob) % 4)
        start = len(self.blob)
        self.blob += data
        return self.add("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data), **more})

    def accessor(self, values: Any, dtype: str = "f4", **more: Any) -> int:
        array = np.asarray(values, f"<{dtype}")
        array = array.reshape(len(array), -1)
        item = {"bufferView": self.view(array.tobytes()), "componentType": TYPES[dtype]}
        return self.add("accessors", {**item, "count": len(array), "type": KINDS[array.shape[1]], **more})

    def texture(self, pixels: Any, **more: Any) -> int:
        image = self.add("images", {"bufferView": self.view(png(pixels)), "mimeType": "image/png"})
        return self.add("textures", {"source": image, **more})

    def material(self, **item: Any) -> int:
        return self.add("materials", item)

    def square(self, material: int | None = None, **attributes: int) -> int:
        """Add a mesh of one square."""
        semantics = {"POSITION": self.accessor(SQUARE), "NORMAL": self.accessor([(0.0, 0.0, 1.0)] * 4)}
        semantics |= {"TEXCOORD_0": self.accessor(SQUARE_UV), **attributes}
        return self.mesh(semantics, indices=self.accessor(SQUARE_INDICES, "u2"), material=material)

    def mesh(self, attributes: dict[str, int], **primitive: Any) -> int:
        options = {key: value for key, value in primitive.items() if value is not None}
        return self.add("meshes", {"primitives": [{"attributes": attributes, **options}]})

    def node(self, **item: Any) -> int:
        """Add a node: a root of the scene, unless another node has it as a child."""
        return self.add("nodes", item)

    def light(self, **item: Any) -> int:
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(item)
        return len(lights) - 1

    def animate(self, node: int, path: str, times: Any, values: Any, interpolation: str = "LINEAR") -> None:
        """Add an animation of one channel."""
        inputs, outputs = self.accessor(times), self.accessor(values)
        sampler = {"input": inputs, "output": outputs, "interpolation": interpolation}
        channel = {"sampler": 0, "target": {"node": node, "path": path}}
        self.add("animations", {"channels": [channel], "samplers": [sampler]})

    def complete(self) -> dict[str, Any]:
        if "scenes" not in self.json and "nodes" in self.json:
            children = {c for n in self.json["nodes"] for c in n.get("children", ())}
            roots = [k for k in range(len(self.json["nodes"])) if k not in children]
            return {**self.json, "scenes": [{"nodes": roots}], "scene": 0}
        return self.json

    def gltf(self, path: Path, uri: str | None = None) -> Path:
        """Write JSON with a data URI, or with the buffer in the file ``uri``."""
        head = self.complete()
        if self.blob:
            if uri is not None:
                (path.parent / uri).write_bytes(self.blob)
            head = {**head, "buffers": [{"byteLength": len(self.blob), "uri": uri or data_uri(self.blob)}]}
        path.write_text(json.dumps(head))
        return path

    def glb(self, path: Path) -> Path:
        head = self.complete()
        if self.blob:
            head = {**head, "buffers": [{"byteLength": len(self.blob)}]}
        path.write_bytes(glb_bytes(json.dumps(head).encode(), self.blob))
        return path


def glb_bytes(text: bytes, blob: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if blob:
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def square_file() -> Builder:
    file = Builder()
    file.node(mesh=file.square())
    return file


def check_error(path: Path, words: str) -> None:
    """Assert that loading fails with a one-line message that contains ``words`` and the file's name."""
    with pytest.raises(UserError, match=words) as caught:
        load_gltf(path)
    message = str(caught.value)
    assert path.stem in message
    assert "\n" not in message
