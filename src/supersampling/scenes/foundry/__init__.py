"""The built-in scene ``foundry``: a hall of 24 x 14 x 8 m full of steel, brick, meshes and moving machines."""

from supersampling.scenes.foundry.foundry import foundry

__all__ = ["foundry"]
