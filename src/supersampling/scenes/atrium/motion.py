"""Moving parts of the atrium: banners, the armillary sphere, kiosks, the cart, a lantern and the clocks' hands."""

import numpy as np

from supersampling.scenes.atrium import parts
from supersampling.scenes.atrium.materials import Palette
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import bookcase
from supersampling.scenes.kit.motion import chain, rotation, shuttle, spin, sway
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, grid, join, lathe, quad, sphere
from supersampling.scenes.kit.wheels import hoop, wheel

WHEEL = 0.2  # radius of the cart's wheels, metres
TRACK = 6.5  # the cart runs between x = -TRACK and TRACK
CART_HERTZ = 0.04


def movers(b: Builder, p: Palette) -> None:
    """Add all moving objects."""
    _banners(b, p)
    _sphere(b, p)
    _kiosks(b, p)
    _cart(b, p)
    _clocks(b, p)
    cage, glass = parts.lantern()
    b.move([(cage, p.iron), (glass, p.glow)], sway((8.4, 4.6, 6.2), (0.3, 0, 1), 14, 0.42))


def _banners(b: Builder, p: Palette) -> None:
    """Add cloths on the cables across the court, printed on both sides."""
    front = quad((-0.35, -0.03, 0.008), (0.7, 0, 0), (0, -2.1, 0), (4, 1))
    cloth = join([front, front.turn_y(180)])
    bars = join([box((0.78, 0.05, 0.05), (0, -0.03, 0)), box((0.74, 0.04, 0.04), (0, -2.13, 0))])
    for k, x in enumerate((-7.0, -4.2, 4.2, 7.0)):
        for j, z in enumerate((-2.1, 1.3)):
            motion = sway((x, 4.86, z), (0, 0, 1), 9 + 2 * j, 0.38 + 0.03 * k, 1.3 * k + j)
            b.move([(cloth.turn_y(90), p.banners[(k + j) % 4]), (bars.turn_y(90), p.oak)], motion)


def _sphere(b: Builder, p: Palette) -> None:
    """Add an armillary sphere: an outer cage that turns, and rings and a globe that turn inside it."""
    meridian, inner = hoop(0.85, 0.05, 0.08), hoop(0.66, 0.04, 0.06)
    flat = rotation((1, 0, 0), np.pi / 2)
    outer = join([meridian, meridian.turn_y(90), meridian.transform(flat)])
    b.move([(outer, p.brass)], spin((0, 2.4, 0), (0, 1, 0), 0.11))
    core = join([inner, inner.transform(flat), beam((0, -0.64, 0), (0, 0.64, 0), 0.02)])
    turn = chain(spin((0, 2.4, 0), (0.35, 1, 0), -0.17), spin((0, 0, 0), (1, 0, 0.4), 0.09))
    b.move([(core, p.brass), (sphere(0.26, 32), p.cart)], turn)


def _kiosks(b: Builder, p: Palette) -> None:
    """Add round pillars that turn, pasted with four sheets each."""
    cap = join([lathe([(0.05, 2.75), (0.12, 2.7), (0.5, 2.5), (0.6, 2.48), (0.6, 2.4), (0.0, 2.4)], 24)])
    foot = lathe([(0.52, 0.5), (0.52, 0.28)], 32)
    for k, x in enumerate((-5.8, 5.8)):
        shapes = [(cap, p.brass), (foot, p.cart)]
        for j in range(4):
            sheet = _arc(0.5, j * np.pi / 2)
            shapes.append((sheet.shift(0, 0.5, 0), (p.papers[j] if j % 2 == k else p.posters[j])))
            shapes.append((sheet.shift(0, 1.45, 0), (p.posters[j] if j % 2 == k else p.papers[j])))
        b.move(shapes, spin((x, 0, 0), (0, 1, 0), 0.09 * (1 - 2 * k)))


def _arc(radius: float, start: float, height: float = 0.95) -> Shape:
    """Return a quarter of a cylinder with uv from 0 to 1."""
    u = np.linspace(0, 1, 13)
    angle = start + u * np.pi / 2
    ring = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1)
    points = np.stack([ring * radius + [0, height, 0], ring * radius])
    uv = np.stack([np.stack([u, 0 * u], 1), np.stack([u, 0 * u + 1], 1)])
    return grid(points, np.stack([ring, ring]), uv)


def _cart(b: Builder, p: Palette) -> None:
    """Add a book cart on rails; its wheels roll."""
    ends = (-TRACK, WHEEL + 0.02, 2.9), (TRACK, WHEEL + 0.02, 2.9)
    wood, books = bookcase(np.random.default_rng(3), 1.2, 2)
    body = [
        box((1.5, 0.12, 0.5), (0, 0.12, 0)),
        box((0.06, 0.1, 0.5), (-0.72, 0.23, 0)),
        box((0.06, 0.1, 0.5), (0.72, 0.23, 0)),
    ]
    sides = [(s.turn_y(t).shift(0, 0.18, 0), m) for t in (0, 180) for s, m in ((wood, p.oak), (books, p.spines))]
    handle = join([beam((x, 0.2, 0), (x, 1.1, 0), 0.03) for x in (-0.74, 0.74)])
    trip = shuttle(*ends, CART_HERTZ)
    b.move([(join(body), p.cart), (handle, p.iron), *sides], trip)
    tyre, hub = wheel(WHEEL)
    pair = [(s.shift(0, 0, z), m) for z in (-0.28, 0.28) for s, m in ((tyre, p.brass), (hub, p.iron))]
    for x in (-0.5, 0.5):
        roll = sway((x, 0, 0), (0, 0, 1), -np.degrees(TRACK / WHEEL), CART_HERTZ, -np.pi / 2)
        b.move(pair, chain(trip, roll))


def _clocks(b: Builder, p: Palette) -> None:
    """Add two hands on the clocks of both end walls."""
    for side in (-1, 1):
        for length, width, hertz, out in ((0.62, 0.05, 0.12, 0.03), (0.42, 0.08, 0.01, 0.015)):
            hand = box((width, length, 0.012), (0, length / 2 - 0.08, out))
            knob = cylinder(0.05, 0.03, 12).transform(rotation((1, 0, 0), np.pi / 2)).shift(0, 0, out)
            shape = join([hand, knob]).turn_y(-90 * side)
            b.move([(shape, p.iron)], spin((side * 10.9, 3.9, 0), (-side, 0, 0), -hertz))
