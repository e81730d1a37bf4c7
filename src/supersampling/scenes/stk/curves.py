"""Keyframed animation as SuperTuxKart plays it (``src/animations/ipo.cpp``).

Frame 1 is time 0, at 25 frames per second. A Bezier segment uses the values of its handles but not their times: the
parameter runs evenly from key to key. Outside its keys a curve is constant (``const``) or repeats (``cyclic``).
"""

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from supersampling.errors import UserError
from supersampling.scenes.stk.numbers import attribute, number

FRAMES_PER_SECOND = 25.0
CHANNELS = ("LocX", "LocY", "LocZ", "RotX", "RotY", "RotZ", "ScaleX", "ScaleY", "ScaleZ")


@dataclass(frozen=True)
class Key:
    """Key at ``seconds`` with the values of its handles towards the previous and the next key."""

    seconds: float
    value: float
    before: float = 0.0
    after: float = 0.0


@dataclass(frozen=True)
class Curve:
    """Number as a function of time. ``interpolation`` is ``bezier``, ``linear`` or ``const``."""

    keys: tuple[Key, ...]
    interpolation: str
    cyclic: bool

    def value(self, seconds: float) -> float:
        """Return the value at ``seconds``."""
        t = self._wrapped(seconds)
        # The last segment includes its end; a single key is a constant.
        n = min(max(bisect_right([key.seconds for key in self.keys], t) - 1, 0), max(len(self.keys) - 2, 0))
        left, right = self.keys[n], self.keys[min(n + 1, len(self.keys) - 1)]
        span = right.seconds - left.seconds
        if self.interpolation == "const" or span <= 0.0:
            return left.value
        u = (t - left.seconds) / span
        if self.interpolation == "linear":
            return left.value + u * (right.value - left.value)
        return _cubic_bezier(u, left.value, left.after, right.before, right.value)

    def _wrapped(self, seconds: float) -> float:
        start, end = self.keys[0].seconds, self.keys[-1].seconds
        if start <= seconds <= end:
            return seconds
        if self.cyclic and end > start:
            # The game's formula: C's fmod of the time itself, not of the time since the start.
            return min(max(start + math.fmod(seconds, end - start), start), end)
        return start if seconds < start else end


def _cubic_bezier(u: float, p0: float, p1: float, p2: float, p3: float) -> float:
    v = 1.0 - u
    return v * v * v * p0 + 3.0 * v * v * u * p1 + 3.0 * v * u * u * p2 + u * u * u * p3


def read_curves(element: Element) -> Mapping[str, Curve]:
    """Return the curves of an object by channel, without channels that objects do not use (those of cannons)."""
    rate = attribute(element, "fps", FRAMES_PER_SECOND)
    if rate <= 0.0:
        raise UserError(f"Invalid fps {rate} of an animation in the track's data: reinstall the SuperTuxKart data.")
    curves = {}
    for node in element.findall("curve"):
        channel = node.get("channel", "")
        keys = tuple(sorted((_key(point, rate) for point in node.findall("p")), key=lambda key: key.seconds))
        if channel in CHANNELS and keys:
            curves[channel] = Curve(keys, node.get("interpolation", "bezier"), node.get("extend") == "cyclic")
    return curves


def _key(point: Element, rate: float) -> Key:
    frame, value = _pair(point.get("c", "1 0"))
    before = _pair(point.get("h1", f"0 {value}"))[1]
    after = _pair(point.get("h2", f"0 {value}"))[1]
    return Key((frame - 1.0) / rate, value, before, after)


def _pair(text: str) -> tuple[float, float]:
    first, _, second = text.strip().partition(" ")
    return number(first), number(second)
