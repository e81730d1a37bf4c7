"""The built-in scene ``market``: a town square of 30 x 20 m on a market day, under a low sun."""

from .market import market

__all__ = ["market"]
