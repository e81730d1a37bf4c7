"""The built-in scene ``market``: a town square of 30 x 20 m on a market day, under a low sun."""

from supersampling.scenes.market.market import market

__all__ = ["market"]
