"""The built-in scene ``louvres``: a street of louvres, fins, slats, meshes and stripes in clear daylight, all matt."""

from .louvres import louvres

__all__ = ["louvres"]
