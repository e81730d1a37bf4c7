"""The built-in scene ``bar``: a bar at night, all lacquer, brass, glazed tiles and glass under lamps and neon."""

from .bar import bar

__all__ = ["bar"]
