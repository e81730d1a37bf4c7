"""Shapes of the bar's furniture in their own frames: they stand on y = 0 (or hang from it) and look along +z."""

import numpy as np

from supersampling.scenes.bar.shapes import sweep
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, sphere, tube

# Profiles (radius, y) of bottles, from the cork down.
_BOTTLES = (
    ((0, 0.32), (0.014, 0.32), (0.014, 0.28), (0.013, 0.24), (0.02, 0.21), (0.036, 0.185), (0.038, 0.02), (0.034, 0)),
    ((0, 0.3), (0.017, 0.3), (0.017, 0.265), (0.014, 0.26), (0.014, 0.22), (0.045, 0.2), (0.047, 0.19), (0.047, 0.01),
     (0.04, 0)),
    ((0, 0.28), (0.024, 0.28), (0.026, 0.25), (0.015, 0.235), (0.014, 0.2), (0.03, 0.17), (0.055, 0.1), (0.058, 0.04),
     (0.04, 0)),
    ((0, 0.36), (0.012, 0.36), (0.012, 0.31), (0.014, 0.26), (0.026, 0.2), (0.032, 0.14), (0.032, 0.01), (0.028, 0)),
    ((0, 0.26), (0.026, 0.26), (0.026, 0.225), (0.016, 0.22), (0.016, 0.19), (0.056, 0.17), (0.058, 0.01), (0.05, 0)),
)  # fmt: skip
_LABELS = ((0.038, 0.06, 0.15), (0.0475, 0.05, 0.16), None, (0.0325, 0.03, 0.11), (0.058, 0.05, 0.13))
_GLASSES = (
    ((0.001, 0.1), (0.05, 0.165), (0.052, 0.167), (0.005, 0.092), (0.004, 0.012), (0.036, 0.004), (0.037, 0)),
    ((0.001, 0.012), (0.03, 0.014), (0.036, 0.1), (0.038, 0.1), (0.033, 0)),
    ((0.001, 0.09), (0.024, 0.1), (0.034, 0.13), (0.028, 0.19), (0.03, 0.19), (0.036, 0.13), (0.024, 0.09),
     (0.004, 0.08), (0.004, 0.01), (0.034, 0.004), (0.035, 0)),
)  # fmt: skip


def bottle(kind: int, cell: int) -> tuple[Shape, Shape | None]:
    """Return the glass, and its label that shows a cell of the 4 x 4 sheet (uv in texture units)."""
    band = _LABELS[kind]
    if band is None:
        return lathe(_BOTTLES[kind], 9), None
    radius, low, high = band
    label = lathe([(radius + 0.001, high), (radius + 0.001, low)], 9)
    uv = label.uv / [2 * np.pi * (radius + 0.001), high - low]
    uv = (uv * [0.98, 0.98] + 0.01 + [cell % 4, cell // 4]) / 4
    return lathe(_BOTTLES[kind], 9), Shape(label.positions, label.normals, uv, label.triangles)


def drinking_glass(kind: int) -> Shape:
    return lathe(_GLASSES[kind], 10)


def stool() -> tuple[Shape, Shape, Shape]:
    """Return the chrome foot and stem of a bar stool, its brass ring and its round seat."""
    stem = [(0.0, 0.7), (0.12, 0.69), (0.05, 0.66), (0.03, 0.62), (0.03, 0.1), (0.05, 0.06), (0.2, 0.03), (0.22, 0.0)]
    angle = np.linspace(0, 2 * np.pi, 18, endpoint=False)
    ring = np.stack([0.19 * np.cos(angle), 0 * angle + 0.3, 0.19 * np.sin(angle)], 1)
    brass = [tube(ring, 0.012, 5, True)]
    brass += [beam((0, 0.3, 0), (0.19 * np.cos(a), 0.3, 0.19 * np.sin(a)), 0.014) for a in (0.4, 2.5, 4.6)]
    seat = [(0.0, 0.795), (0.1, 0.79), (0.165, 0.775), (0.19, 0.745), (0.185, 0.71), (0.16, 0.69), (0, 0.69)]
    return (
        lathe(stem, 16),
        join([*brass, lathe([(0.188, 0.725), (0.196, 0.72), (0.196, 0.705), (0.186, 0.7)], 14)]),
        lathe(seat, 18),
    )


def table(radius: float = 0.42, height: float = 0.74) -> tuple[Shape, Shape]:
    """Return the lacquered top of a round table, and its brass rim and pedestal."""
    top = lathe([(0, height), (radius - 0.01, height), (radius, height - 0.008)], 32)
    # A lathe's uv suit walls; a top is mapped from above.
    top = Shape(top.positions, top.normals, top.positions[:, [0, 2]], top.triangles)
    foot = [
        (radius, height - 0.008),
        (radius + 0.004, height - 0.016),
        (radius - 0.004, height - 0.035),
        (0.06, height - 0.04),
    ]
    foot += [(0.035, height - 0.1), (0.028, 0.3), (0.05, 0.22), (0.03, 0.16), (0.06, 0.07), (0.25, 0.025), (0.27, 0.0)]
    return top, lathe(foot, 16)


def chair() -> tuple[Shape, Shape]:
    """Return the black frame of a bentwood chair, and its upholstered seat."""
    angle = np.linspace(0, np.pi, 12)
    hoops = []
    for wide, high in ((0.2, 0.42), (0.12, 0.3)):
        bow = np.stack([wide * np.cos(angle), 0.47 + high * np.sin(angle), -0.17 - 0.1 * np.sin(angle)], 1)
        hoops.append(tube(bow, 0.013, 4))
    legs = [
        tube([(x, 0.46, z), (1.15 * x, 0.2, 1.12 * z), (1.3 * x, 0, 1.3 * z)], 0.014, 4)
        for x in (-0.15, 0.15)
        for z in (-0.15, 0.15)
    ]
    ring = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    brace = tube(np.stack([0.155 * np.cos(ring), 0 * ring + 0.22, 0.155 * np.sin(ring)], 1), 0.009, 4, True)
    rim = lathe([(0.205, 0.475), (0.21, 0.46), (0.2, 0.44)], 18)
    return join([*hoops, *legs, brace, rim]), lathe([(0, 0.5), (0.12, 0.495), (0.19, 0.485), (0.205, 0.475)], 18)


def bench(width: float) -> tuple[Shape, Shape]:
    """Return an upholstered bench with its back to z = 0, and its wooden plinth, cap and end boards."""
    line = np.array([(-width / 2, 0.0), (0.0, 0.0), (width / 2, 0.0)])
    soft = [
        (0.1, 1.16),
        (0.16, 1.12),
        (0.24, 0.52),
        (0.56, 0.49),
        (0.62, 0.46),
        (0.64, 0.4),
        (0.62, 0.34),
        (0.58, 0.33),
    ]
    hard = [box((width, 0.33, 0.52), (0, 0.165, 0.27), ("front",)), box((width, 0.05, 0.18), (0, 1.185, 0.09))]
    hard += [box((0.06, 1.24, 0.7), (side * (width / 2 + 0.03), 0.62, 0.35)) for side in (-1, 1)]
    return sweep(line, soft), join(hard)


def pendant(drop: float) -> tuple[Shape, Shape, Shape]:
    """Return a lamp ``drop`` metres below the origin: metal shade and rod, cream inside, bulb."""
    dome = [(0.02, 0.2), (0.04, 0.2), (0.05, 0.16), (0.1, 0.15), (0.17, 0.1), (0.2, 0.02), (0.205, 0.0)]
    inside = [(0.203, 0.0), (0.195, 0.02), (0.165, 0.095), (0.09, 0.145), (0, 0.15)]
    rod = [
        cylinder(0.006, drop - 0.2, 6).shift(0, -(drop - 0.2) / 2, 0),
        lathe([(0.02, 0.0), (0.05, -0.03), (0.06, -0.03)], 16),
    ]
    return (
        join([lathe(dome, 22).shift(0, -drop, 0), *rod]),
        lathe(inside, 22).shift(0, -drop, 0),
        sphere(0.05, 14).shift(0, 0.05 - drop, 0),
    )


def taps(count: int) -> tuple[Shape, Shape]:
    """Return a brass beam on two columns with spouts that look along -z, and the handles."""
    width = 0.14 * count
    arms = [tube([(x, 0.0, 0), (x, 0.3, 0)], 0.03, 12) for x in (-width / 2 + 0.1, width / 2 - 0.1)]
    arms += [
        lathe([(0.03, 0.05), (0.07, 0.02), (0.075, 0)], 18).shift(x, 0, 0) for x in (-width / 2 + 0.1, width / 2 - 0.1)
    ]
    arms += [
        tube([(-width / 2, 0.3, 0), (width / 2, 0.3, 0)], 0.04, 16),
        *(sphere(0.05, 10).shift(s * width / 2, 0.3, 0) for s in (-1, 1)),
    ]
    handles = []
    for x in (np.arange(count) - (count - 1) / 2) * 0.14:
        arms.append(tube([(x, 0.3, 0), (x, 0.3, -0.09), (x, 0.27, -0.12), (x, 0.2, -0.12)], 0.013, 7))
        arms.append(tube([(x, 0.33, -0.06), (x, 0.38, -0.06)], 0.01, 6))
        handles.append(
            lathe([(0, 0.2), (0.016, 0.195), (0.022, 0.16), (0.012, 0.03), (0.012, 0)], 10).shift(x, 0.37, -0.06)
        )
    return join(arms), join(handles)


def fan(blades: int, radius: float) -> tuple[Shape, Shape]:
    """Return the wooden blades of a ceiling fan about the y axis, and its brass hub and arms."""
    wood, brass = ([], [lathe([(0.03, 0.12), (0.09, 0.08), (0.12, 0.03), (0.1, -0.03), (0.04, -0.07), (0, -0.08)], 24)])
    for i in range(blades):
        turn = 360 / blades * i
        blade = box((radius - 0.22, 0.012, 0.15), (0.22 + (radius - 0.22) / 2, 0, 0)).transform(
            rotation((1, 0, 0), 0.22)
        )
        wood.append(blade.turn_y(turn))
        brass.append(box((0.2, 0.015, 0.05), (0.18, 0.004, 0)).transform(rotation((1, 0, 0), 0.22)).turn_y(turn))
    return join(wood), join(brass)
