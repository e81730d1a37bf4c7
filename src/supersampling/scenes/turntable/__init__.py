"""The built-in scene ``turntable``: a carved machine turns slowly in a studio; every camera stands still."""

from supersampling.scenes.turntable.turntable import turntable

__all__ = ["turntable"]
