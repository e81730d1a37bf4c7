"""A user's own glTF 2.0 file, ``.gltf`` or ``.glb``, as a scene."""

from .fingerprint import fingerprint
from .load import load_gltf

__all__ = ["fingerprint", "load_gltf"]
