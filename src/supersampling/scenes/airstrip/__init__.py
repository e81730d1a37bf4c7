"""The built-in scene ``airstrip``: racing planes, lorries and drones go round an infield, fast, before painted walls."""

from supersampling.scenes.airstrip.airstrip import airstrip

__all__ = ["airstrip"]
