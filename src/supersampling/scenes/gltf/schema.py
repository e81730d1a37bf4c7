"""Types of the JSON values that the reader uses, from the specification's schema."""

import json
from typing import Any

from supersampling.errors import UserError

_KINDS = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
_ANY = "*"  # as a key: every key
_TRANSFORM = {"offset": [float], "rotation": float, "scale": [float], "texCoord": int}
_TEXTURE = {
    "index": int,
    "texCoord": int,
    "scale": float,
    "strength": float,
    "extensions": {"KHR_texture_transform": _TRANSFORM},
}
_VIEW = {"bufferView": int, "byteOffset": int, "componentType": int}
_LIGHT = {
    "type": str,
    "color": [float],
    "intensity": float,
    "range": float,
    "spot": {"innerConeAngle": float, "outerConeAngle": float},
}
_SHAPE = {
    "asset": {"version": str, "minVersion": str},
    "scene": int,
    "extensionsUsed": [str],
    "extensionsRequired": [str],
    "extensions": {"KHR_lights_punctual": {"lights": [_LIGHT]}},
    "scenes": [{"nodes": [int]}],
    "nodes": [
        {
            "name": str,
            "children": [int],
            "mesh": int,
            "skin": int,
            "camera": int,
            "weights": [float],
            "matrix": [float],
            "translation": [float],
            "rotation": [float],
            "scale": [float],
            "extensions": {"KHR_lights_punctual": {"light": int}},
        }
    ],
    "meshes": [
        {
            "weights": [float],
            "primitives": [
                {"attributes": {_ANY: int}, "indices": int, "material": int, "mode": int}
                | {"targets": [{_ANY: int}], "extensions": {_ANY: {}}}
            ],
        }
    ],
    "accessors": [
        {
            **_VIEW,
            "count": int,
            "type": str,
            "normalized": bool,
            "sparse": {"count": int, "indices": _VIEW, "values": _VIEW},
        }
    ],
    "bufferViews": [{"buffer": int, "byteOffset": int, "byteLength": int, "byteStride": int}],
    "buffers": [{"byteLength": int, "uri": str}],
    "images": [{"bufferView": int, "uri": str}],
    "textures": [{"source": int, "sampler": int}],
    "samplers": [{"magFilter": int, "minFilter": int, "wrapS": int, "wrapT": int}],
    "materials": [
        {
            "name": str,
            "pbrMetallicRoughness": {
                "baseColorFactor": [float],
                "baseColorTexture": _TEXTURE,
                "metallicFactor": float,
                "roughnessFactor": float,
                "metallicRoughnessTexture": _TEXTURE,
            },
            "normalTexture": _TEXTURE,
            "occlusionTexture": _TEXTURE,
            "emissiveTexture": _TEXTURE,
            "emissiveFactor": [float],
            "alphaMode": str,
            "alphaCutoff": float,
            "doubleSided": bool,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": float}},
        }
    ],
    "skins": [{"joints": [int], "inverseBindMatrices": int}],
    "cameras": [{"name": str, "perspective": {"yfov": float, "znear": float, "zfar": float, "aspectRatio": float}}],
    "animations": [
        {
            "channels": [{"sampler": int, "target": {"node": int, "path": str}}],
            "samplers": [{"input": int, "output": int, "interpolation": str}],
        }
    ],
}


def check_types(head: dict[str, Any], name: str) -> None:
    """Raise `UserError` if a value that the reader uses has another type than in the specification; null is allowed."""
    _check(head, _SHAPE, "", name)


def _check(value: Any, shape: Any, place: str, name: str) -> None:
    if value is None:
        return
    if isinstance(shape, dict):
        _expect(isinstance(value, dict), value, "an object", place, name)
        for key in value if _ANY in shape else shape:
            _check(value.get(key), shape.get(_ANY, shape.get(key)), f"{place}.{key}".lstrip("."), name)
    elif isinstance(shape, list):
        _expect(isinstance(value, list), value, "a list", place, name)
        for k, item in enumerate(value):
            _expect(item is not None, item, "an item", f"{place}[{k}]", name)
            _check(item, shape[0], f"{place}[{k}]", name)
    else:
        allowed = (int, float) if shape is float else shape
        fits = isinstance(value, allowed) and (shape is bool or not isinstance(value, bool))
        _expect(fits, value, _KINDS[shape], place, name)


def _expect(fits: bool, value: Any, kind: str, place: str, name: str) -> None:
    if not fits:
        raise UserError(f"Invalid {place} of {name}: {json.dumps(value)[:60]} is not {kind}: export it again.")
