"""The built-in scene ``arena``: walking robots under name plates, and a head-up display before the camera."""

from supersampling.scenes.arena.arena import arena

__all__ = ["arena"]
