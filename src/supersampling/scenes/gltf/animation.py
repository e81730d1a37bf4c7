"""Node animation: keyframes of translation, rotation and scale, at any time (specification, sections 3.11 and C)."""

from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.accessors import Accessors
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.notes import Notes

Vector = NDArray[np.float64]
FARTHEST = 1e12  # metres; beyond, single precision cannot separate vertices
PATHS = {"translation": 3, "rotation": 4, "scale": 3}


def slerp(a: Vector, b: Vector, t: float) -> Vector:
    """Interpolate unit quaternions ``(x, y, z, w)`` along the shorter arc; nearly equal ones linearly."""
    cosine = float(a @ b)
    if cosine < 0.0:
        b, cosine = -b, -cosine
    if cosine > 0.9999995:  # arcs below 0.1 degrees: the sine in the denominator is nearly zero
        return _unit(a + t * (b - a))
    angle = np.arccos(cosine)
    return (np.sin((1.0 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)


def _unit(quaternion: Vector) -> Vector:
    # A quaternion without length means no rotation.
    length = float(np.linalg.norm(quaternion))
    return quaternion / length if length > 1e-12 else np.array((0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Keyframes of one property: rising ``times (K,)`` and ``values (K, n)``.

    Values are ``(K, 3, n)``, with tangents, for CUBICSPLINE.

    The animation repeats every ``period`` seconds, the last time of its longest curve.
    """

    times: Vector
    values: Vector
    interpolation: str
    quaternion: bool
    period: float
    keys: list[float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "keys", self.times.tolist())

    @property
    def constant(self) -> bool:
        """Whether all keys are equal and all tangents zero."""
        if self.interpolation == "CUBICSPLINE":
            return bool((self.values[:, 1] == self.values[0, 1]).all()) and not self.values[:, (0, 2)].any()
        return bool((self.values == self.values[0]).all())

    def value(self, seconds: float) -> Vector:
        """Return the value ``(n,)``, constant before the first and after the last key."""
        t = seconds % self.period if self.period > 0.0 else 0.0
        n = bisect_right(self.keys, t) - 1
        if n < 0 or n >= len(self.keys) - 1:
            value = self._key(0 if n < 0 else -1)
            return _unit(value) if self.quaternion else value
        span = self.keys[n + 1] - self.keys[n]
        value = self._between(n, (t - self.keys[n]) / span, span)
        return _unit(value) if self.quaternion else value

    def _key(self, n: int) -> Vector:
        return self.values[n, 1] if self.interpolation == "CUBICSPLINE" else self.values[n]

    def _between(self, n: int, u: float, span: float) -> Vector:
        if self.interpolation == "STEP":
            return self.values[n]
        if self.interpolation == "CUBICSPLINE":
            (_, p, m), (w, q, _) = self.values[n], self.values[n + 1]
            u2, u3 = u * u, u * u * u
            hermite = (2 * u3 - 3 * u2 + 1) * p + span * (u3 - 2 * u2 + u) * m + (3 * u2 - 2 * u3) * q
            return hermite + span * (u3 - u2) * w
        if self.quaternion:
            return slerp(_unit(self.values[n]), _unit(self.values[n + 1]), u)
        return self.values[n] + u * (self.values[n + 1] - self.values[n])


def local_matrix(translation: Vector, rotation: Vector, scale: Vector) -> Vector:
    """Return the matrix ``(4, 4)`` T R S; the rotation is a unit quaternion ``(x, y, z, w)``.

    A scale of zero becomes a millionth, which looks the same: normals need an invertible matrix.
    """
    x, y, z, w = rotation
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= np.where(np.abs(scale) < 1e-6, 1e-6, scale)
    out[:3, 3] = translation
    return out


def moving_matrix(rest: Mapping[str, Vector], curves: Mapping[str, Keyframes]) -> Callable[[float], Vector]:
    """Return a node's local matrix as a function of seconds: its parts at rest, some of them replaced by curves."""

    def matrix(seconds: float) -> Vector:
        parts = {path: curves[path].value(seconds) if path in curves else rest[path] for path in PATHS}
        return local_matrix(parts["translation"], parts["rotation"], parts["scale"])

    return matrix


def read_keyframes(document: Document, accessors: Accessors, notes: Notes) -> dict[int, dict[str, Keyframes]]:
    """Return curves by node and path. All animations play at once; if several move the same property the first wins."""
    curves: dict[int, dict[str, Keyframes]] = {}
    for number, animation in enumerate(document.gltf.animations):
        what = f"animation {number} of {document.name}"
        samplers = [(c, _sampler(animation, c.sampler, what)) for c in animation.channels]
        inputs = [_times(accessors, s.input, what) for _, s in samplers]
        period = max((float(times[-1]) for times in inputs), default=0.0)
        for (channel, sampler), times in zip(samplers, inputs):
            node, path = channel.target.node, channel.target.path
            if node is None or path not in PATHS:
                notes.add(Deviation.WEIGHTS if path == "weights" else Deviation.CHANNELS)
                continue
            document.item("nodes", node)
            if path in curves.setdefault(node, {}):
                notes.add(Deviation.TWICE)
                continue
            curves[node][path] = _curve(accessors, times, sampler, path, period, what)
    return curves


def _sampler(animation: Any, index: int, what: str) -> Any:
    if not 0 <= index < len(animation.samplers):
        raise UserError(f"Sampler {index} of {what} does not exist: the file is broken, export it again.")
    return animation.samplers[index]


def _times(accessors: Accessors, index: int, what: str) -> Vector:
    times = accessors.floats(index, 1)[:, 0].astype(np.float64)
    if not np.isfinite(times).all() or times[0] < 0.0 or (np.diff(times) <= 0.0).any():
        raise UserError(f"The key times of {what} do not rise from zero: the file is broken, export it again.")
    return times


def _curve(accessors: Accessors, times: Vector, sampler: Any, path: str, period: float, what: str) -> Keyframes:
    kind = sampler.interpolation or "LINEAR"
    if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
        raise UserError(f"Unknown interpolation {kind} of {what}: use LINEAR, STEP or CUBICSPLINE.")
    values = accessors.floats(sampler.output, PATHS[path]).astype(np.float64)
    per_key = 3 if kind == "CUBICSPLINE" else 1
    if len(values) != per_key * len(times) or not (np.abs(values) < FARTHEST).all():
        raise UserError(
            f"A {path} of {what} has {len(values)} values for {len(times)} keys, or some above {FARTHEST:.0e}: "
            "the file is broken, export it again."
        )
    if kind == "CUBICSPLINE":
        values = values.reshape(len(times), 3, -1)
    return Keyframes(times, values, kind, path == "rotation", period)
