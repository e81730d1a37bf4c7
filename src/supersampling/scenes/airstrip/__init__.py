"""The built-in scene ``airstrip``: planes, lorries and drones race round an infield before painted walls."""

from supersampling.scenes.airstrip.airstrip import airstrip

__all__ = ["airstrip"]
