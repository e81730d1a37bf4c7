"""The built-in scene ``louvres``: a street of louvres, fins, slats, meshes and stripes in clear daylight, all matt."""

from supersampling.scenes.louvres.louvres import louvres

__all__ = ["louvres"]
