"""The built-in scene ``sundial``: a painted court and a lamp chamber that stand still, while shadows turn over them."""

from supersampling.scenes.sundial.sundial import sundial

__all__ = ["sundial"]
