"""The built-in scene ``bar``: a bar at night, all lacquer, brass, glazed tiles and glass under lamps and neon."""

from supersampling.scenes.bar.bar import bar

__all__ = ["bar"]
