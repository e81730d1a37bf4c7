"""A user's own glTF 2.0 file, ``.gltf`` or ``.glb``, as a scene."""

from supersampling.scenes.gltf.fingerprint import fingerprint
from supersampling.scenes.gltf.load import load_gltf

__all__ = ["fingerprint", "load_gltf"]
