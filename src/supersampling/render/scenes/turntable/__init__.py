"""The built-in scene ``turntable``: a carved machine turns slowly in a studio; every camera stands still."""

from .turntable import turntable

__all__ = ["turntable"]
