"""Regular structures: rows of fins, slats and rods, corrugated sheets, meshes, railings, blinds and striped things.

They stand on y = 0 (or hang from it) and look along +z; lengths are metres.
"""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, grid, join, lathe, panel, sphere, tube

# The faces of blades before a wall, of which the back is never seen.
_UPRIGHT = ("front", "left", "right")
_LYING = ("front", "top", "bottom")


def copies(shape: Shape, places: ArrayLike) -> Shape:
    """Return ``shape`` at each of ``places (N, 3)``, its texture shifted from one to the next."""
    points = np.asarray(places, float)
    count, size = len(points), len(shape.positions)
    shift = 0.37 * np.arange(count)[:, None, None]
    triangles = shape.triangles[None] + size * np.arange(count)[:, None, None]
    return Shape(
        (shape.positions[None] + points[:, None]).reshape(-1, 3),
        np.tile(shape.normals, (count, 1)),
        (shape.uv[None] + shift).reshape(-1, 2),
        triangles.reshape(-1, 3),
    )


def _steps(length: float, pitch: float) -> np.ndarray:
    """Return the middles of whole periods of about ``pitch`` that fill ``length`` about zero."""
    count = max(round(length / pitch), 1)
    return (np.arange(count) + 0.5) * length / count - length / 2


def _places(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*(np.asarray(v, float) for v in (x, y, z))), -1)


def fins(width: float, height: float, pitch: float, thick: float, depth: float, turn: float = 0.0) -> Shape:
    """Return upright blades side by side before a wall, each turned by ``turn`` degrees about its axis."""
    blade = box((thick, height, depth), (0, height / 2, 0), _UPRIGHT).turn_y(turn)
    return copies(blade, _places(_steps(width, pitch), 0, 0))


def slats(width: float, height: float, pitch: float, thick: float, depth: float, tilt: float = 0.0) -> Shape:
    """Return level blades one above another before a wall, their front edges tilted down by ``tilt`` degrees."""
    blade = box((width, thick, depth), (0, 0, 0), _LYING).transform(rotation((1, 0, 0), np.radians(tilt)))
    return copies(blade, _places(0, _steps(height, pitch) + height / 2, 0))


def rods(width: float, height: float, pitch: float, radius: float) -> Shape:
    """Return thin upright bars side by side."""
    return copies(tube([(0, 0, 0), (0, height, 0)], radius, 3), _places(_steps(width, pitch), 0, 0))


def mesh(width: float, height: float, pitch: float, radius: float) -> Shape:
    """Return a welded wire mesh: upright and level wires."""
    level = tube([(-width / 2, 0, radius), (width / 2, 0, radius)], radius, 3)
    upright = copies(tube([(0, 0, 0), (0, height, 0)], radius, 3), _places(_steps(width, pitch), 0, 0))
    return join([upright, copies(level, _places(0, _steps(height, pitch) + height / 2, 0))])


def framed_mesh(width: float, height: float, pitch: float) -> tuple[Shape, Shape]:
    """Return a panel of mesh, and its posts and rails."""
    bars = [box((0.05, height + 0.06, 0.05), (s * width / 2, height / 2, 0)) for s in (-1, 1)]
    bars += [box((width, 0.04, 0.04), (0, y, 0)) for y in (0.06, height)]
    return mesh(width - 0.05, height - 0.1, pitch, 0.0045).shift(0, 0.07, 0), join(bars)


def roof_slats(length: float, depth: float, pitch: float) -> Shape:
    """Return battens on edge along z that lie on a pergola, side by side along x, from y = 0 up."""
    batten = box((0.028, 0.09, depth), (0, 0.045, 0))
    return copies(batten, _places(_steps(length, pitch), 0, 0))


def corrugated(width: float, height: float, pitch: float, depth: float) -> Shape:
    """Return a sheet of upright waves about z = 0."""
    waves = max(round(width / pitch), 1)
    x = np.linspace(-width / 2, width / 2, 6 * waves + 1)
    phase = 2 * np.pi * waves * (x / width + 0.5)
    slope = depth / 2 * np.cos(phase) * 2 * np.pi * waves / width
    n = np.stack([-slope, 0 * x, 1 + 0 * x], 1) / np.hypot(1, slope)[:, None]
    rows = [np.stack([x, 0 * x + y, depth / 2 * np.sin(phase)], 1) for y in (height, 0.0)]
    uv = [np.stack([x, 0 * x + v], 1) for v in (0.0, height)]
    return grid(np.array(rows), np.array([n, n]), np.array(uv))


def shutter(width: float, height: float, pitch: float, depth: float = 0.02) -> Shape:
    """Return a roller shutter of level waves."""
    sheet = corrugated(height, width, pitch, depth).transform(rotation((0, 0, 1), np.pi / 2))
    return sheet.shift(width / 2, height / 2, 0)


def railing(width: float, height: float, pitch: float, radius: float = 0.007) -> Shape:
    """Return balusters between two rails, and posts at the ends."""
    rails = [beam((-width / 2, y, 0), (width / 2, y, 0), 0.035) for y in (0.09, height)]
    posts = [beam((s * width / 2, 0, 0), (s * width / 2, height, 0), 0.045) for s in (-1, 1)]
    return join([rods(width, height - 0.09, pitch, radius).shift(0, 0.09, 0), *rails, *posts])


def frame(width: float, height: float, bar: float = 0.08, depth: float = 0.12) -> Shape:
    """Return a window frame around an opening that stands on y = 0."""
    sides = [box((bar, height + 2 * bar, depth), (s * (width + bar) / 2, height / 2, 0)) for s in (-1, 1)]
    ends = [box((width, bar, depth), (0, y, 0)) for y in (-bar / 2, height + bar / 2)]
    return join([*sides, *ends, box((width + 4 * bar, 0.05, depth + 0.1), (0, -bar - 0.025, 0.04))])


def awning(width: float, reach: float, drop: float) -> tuple[Shape, Shape]:
    """Return striped cloth that slopes out from the origin, with a valance, and the arms that support it."""
    cloth = panel((-width / 2, 0, 0), (width, 0, 0), (0, -drop, reach))
    valance = panel((-width / 2, -drop, reach), (width, 0, 0), (0, -0.22, 0))
    arms = [
        beam((x, -drop - 0.04, reach - 0.02), (x, -drop - 0.35, 0.02), 0.025)
        for x in (-width / 2 + 0.05, width / 2 - 0.05)
    ]
    arms.append(beam((-width / 2, -drop - 0.01, reach - 0.02), (width / 2, -drop - 0.01, reach - 0.02), 0.03))
    return join([cloth, valance]), join(arms)


def parasol(radius: float, height: float) -> tuple[Shape, Shape]:
    """Return cloth of eight panels with a valance, its stripes running from the top down, and pole, ribs and foot."""
    roof = lathe([(0.02, height), (radius, height - 0.42), (radius + 0.005, height - 0.6)], 8)
    pole = [cylinder(0.024, height, 8).shift(0, height / 2, 0), lathe([(0.03, 0.12), (0.28, 0.06), (0.28, 0.0)], 20)]
    for a in np.arange(8) * np.pi / 4:
        rim = (radius * 0.98 * np.sin(a), height - 0.44, radius * 0.98 * np.cos(a))
        pole.append(beam((0, height - 0.03, 0), rim, 0.012))
    return roof, join(pole)


def deck_chair() -> tuple[Shape, Shape]:
    """Return cloth that sags between two bars, and crossed wooden frames."""
    share = np.linspace(0, 1, 9)[:, None]
    back, seat, front = np.array([0, 0.98, -0.42]), np.array([0, 0.12, 0.02]), np.array([0, 0.42, 0.5])
    line = (1 - share) ** 2 * back + 2 * share * (1 - share) * seat + share**2 * front
    slope = np.gradient(line, axis=0)
    n = np.cross(slope, [1.0, 0.0, 0.0])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    x = np.array([-0.26, 0.26])
    points = line[:, None] + x[None, :, None] * [1.0, 0.0, 0.0]
    uv = np.stack(np.broadcast_arrays(x[None], travelled[:, None]), -1)
    cloth = grid(points, np.broadcast_to(n[:, None], points.shape), uv)
    bars = [beam((s * 0.28, 0, 0.42), (s * 0.28, 1.0, -0.43), 0.032) for s in (-1, 1)]
    bars += [beam((s * 0.315, 0, -0.4), (s * 0.315, 0.44, 0.52), 0.032) for s in (-1, 1)]
    bars += [
        beam((-0.32, y, z), (0.32, y, z), 0.03) for y, z in ((0.98, -0.43), (0.42, 0.51), (0.03, -0.38), (0.03, 0.4))
    ]
    return cloth, join(bars)


def bench(width: float) -> tuple[Shape, Shape]:
    """Return the slats and the feet of a bench."""
    seat = copies(box((width, 0.025, 0.03)), _places(0, 0.45, _steps(0.48, 0.048)))
    back = copies(box((width, 0.03, 0.02)), _places(0, 0.56 + _steps(0.36, 0.048) + 0.18, -0.26))
    feet = [box((0.06, 0.44, 0.44), (x, 0.22, 0)) for x in (-width / 2 + 0.15, width / 2 - 0.15)]
    feet += [box((0.05, 0.6, 0.025), (x, 0.65, -0.283)) for x in (-width / 2 + 0.15, width / 2 - 0.15)]
    return join([seat, back]), join(feet)


def planter(size: float) -> tuple[Shape, Shape]:
    """Return a box of battens, and the box tree in it, cut to a ball."""
    sides = join([fins(size, 0.55, 0.05, 0.035, 0.02).shift(0, 0.03, size / 2).turn_y(90 * k) for k in range(4)])
    core = box((size - 0.03, 0.5, size - 0.03), (0, 0.3, 0), ("front", "back", "left", "right", "top"))
    ball = sphere(size * 0.62, 18).shift(0, 0.55 + size * 0.5, 0)
    return join([sides, core]), ball


def cage(radius: float, height: float, count: int, rod: float) -> Shape:
    """Return upright rods around a circle, between two rings."""
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)], 1)
    bars = copies(tube([(0, 0, 0), (0, height, 0)], rod, 4), ring)
    hoop = tube(ring[:: max(count // 40, 1)], 0.022, 6, True)
    return join([bars, hoop, hoop.shift(0, height, 0)])


def grating(width: float, depth: float, pitch: float) -> Shape:
    """Return bars across a drain that lies in the ground, along x."""
    bar = box((0.008, 0.02, depth), (0, -0.01, 0), ("top",))
    return join(
        [
            copies(bar, _places(_steps(width, pitch), 0.012, 0)),
            *(box((width, 0.02, 0.02), (0, 0.002, s * depth / 2), ("top", "front", "back")) for s in (-1, 1)),
        ]
    )


def hanging_blind(width: float, height: float, pitch: float) -> tuple[Shape, Shape]:
    """Return a blind of thin slats that hangs from the origin, and its cords and top rail."""
    cords = [beam((x, 0, 0), (x, -height, 0), 0.008) for x in (-width * 0.36, 0.0, width * 0.36)]
    rails = [box((width + 0.06, 0.05, 0.05), (0, -0.02, 0)), box((width, 0.03, 0.03), (0, -height, 0))]
    blade = box((width, 0.006, 0.036), faces=("front", "back", "top", "bottom")).transform(
        rotation((1, 0, 0), np.radians(28))
    )
    blades = copies(blade, _places(0, _steps(height - 0.1, pitch) - height / 2, 0))
    return blades, join([*cords, *rails])
