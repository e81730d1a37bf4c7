"""Textures of the market: fan-laid cobbles, plaster, shutters, striped canvas, heaped fruit."""

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.kit import textures
from supersampling.scenes.kit.textures import Field, Maps, fractal, normals, picture, ramp, surface
from supersampling.scenes.scene import Texture


def _arcs(size: int, repeats: int, rings: int) -> tuple[NDArray[np.int64], Field]:
    """Return fish-scale paving: a number per stone, and the distance to its joint in shares of a stone."""
    middle, radius = (np.arange(size) + 0.5) / size * repeats, 1 / np.sqrt(2)
    label, joint = np.zeros((size, size), np.int64), np.zeros((size, size))
    # Each row of scales covers the lower part of the one before.
    for row in range(-2, 2 * repeats + 2):
        for column in range(-1, repeats + 2):
            cx, cy = column + 0.5 * (row % 2), row * 0.5
            u, v = np.flatnonzero(np.abs(middle - cx) < radius), np.flatnonzero(np.abs(middle - cy) < radius)
            if len(u) == 0 or len(v) == 0:
                continue
            window = (slice(v[0], v[-1] + 1), slice(u[0], u[-1] + 1))
            x, y = middle[u][None] - cx, middle[v][:, None] - cy
            distance = np.hypot(x, y) / radius * rings
            ring = np.floor(distance)
            turn = np.arctan2(y, x) / np.pi * np.maximum(np.round(np.pi * (ring + 0.5) * 0.95), 2) + 0.5 * (ring % 2)
            edge = np.minimum(np.minimum(distance % 1, 1 - distance % 1), np.minimum(turn % 1, 1 - turn % 1))
            number = (row % (2 * repeats) * repeats + column % repeats) * 331 + ring * 47 + np.floor(turn) % 47
            inside = distance < rings
            joint[window] = np.where(inside, edge, joint[window])
            label[window] = np.where(inside, number, label[window])
    return label, joint


def fan_cobbles(size: int, seed: int, repeats: int = 2) -> Maps:
    """Draw small setts laid in fans, with sand between them."""
    label, joint = _arcs(size, repeats, 7)
    value = np.random.default_rng(seed).random(4096)[label % 4096]
    grit, cloud = textures.resized(textures.photo("gravel"), size), fractal(size, seed, 1.2)
    height = np.clip((joint + 0.1 * (grit - 0.5) - 0.09) * 4, 0, 1) ** 0.6
    tone = np.clip(0.2 + 0.6 * value + 0.7 * (grit - 0.45) + 0.3 * (cloud - 0.5), 0, 1)
    rock = ramp(tone, [(0.26, 0.25, 0.27), (0.5, 0.47, 0.45), (0.72, 0.65, 0.57)])
    sand = ramp(grit, [(0.16, 0.13, 0.09), (0.5, 0.43, 0.32)])
    inside = np.clip(height * 2, 0, 1)[..., None]
    return (
        picture(inside * rock + (1 - inside) * sand),
        normals(height + 0.25 * grit, 6.0),
        surface(0.7 + 0.25 * grit),
    )


def plaster(size: int, seed: int) -> Maps:
    """Draw lime wash, trowelled, with stains and hairline cracks; pale, to be tinted."""
    grain, cloud, stroke = (
        fractal(size, seed, 0.35),
        fractal(size, seed + 1, 1.3),
        fractal(size, seed + 2, 0.8, (2.0, 1.0)),
    )
    streak, web = fractal(size, seed + 3, 0.9, (6.0, 0.4)), fractal(size, seed + 4, 1.2)
    crack = np.clip(1 - np.abs(web - 0.5) * 160, 0, 1) * (cloud > 0.55)
    tone = (
        0.82 + 0.16 * (cloud - 0.5) + 0.16 * (grain - 0.5) + 0.1 * (stroke - 0.5) - 0.12 * np.clip(streak - 0.6, 0, 1)
    )
    warm = np.array([1.0, 0.985, 0.95])
    return (
        picture((tone * (1 - 0.35 * crack))[..., None] * warm),
        normals(0.5 * grain + 0.6 * stroke - 0.5 * crack, 3.5),
        surface(0.8 + 0.2 * grain),
    )


def louvres(size: int, seed: int, slats: int = 16) -> Maps:
    """Draw a shutter: slats in a frame, one picture per shutter; painted pale, to be tinted."""
    y, x = np.mgrid[:size, :size] / size
    frame = (np.minimum(x, 1 - x) < 0.1) | (np.minimum(y, 1 - y) < 0.05) | (np.abs(y - 0.5) < 0.025)
    slope = (y * slats) % 1
    grain, wear = fractal(size, seed, 0.5, (3.0, 1.0)), fractal(size, seed + 1, 1.0)
    tone = np.where(frame, 0.85, 0.35 + 0.55 * slope) * (0.8 + 0.3 * grain)
    color = tone[..., None] * np.where((wear > 0.82)[..., None], (0.8, 0.72, 0.62), (1.0, 1.0, 1.0))
    return picture(color), normals(np.where(frame, 1.2, slope) + 0.1 * grain, 5.0), surface(0.7 + 0.2 * grain)


def awning(
    size: int, seed: int, cloth: tuple[tuple[float, float, float], tuple[float, float, float]], stripes: int = 4
) -> Texture:
    """Draw striped canvas with weave and sun-bleached folds, RGB; stripes run along v."""
    y, x = np.mgrid[:size, :size]
    weave = 0.9 + 0.1 * ((x + y) % 2)
    dark = ((x / size * stripes) % 1 < 0.5)[..., None]
    fold = fractal(size, seed, 1.2, (3.0, 0.7))
    return picture(np.where(dark, cloth[1], cloth[0]) * (weave * (0.82 + 0.3 * fold))[..., None])


def fruit(size: int, seed: int, count: int, stops: tuple[tuple[float, ...], ...]) -> Maps:
    """Draw a heap of round fruit seen from above: spheres of several sizes, each with its own blush."""
    rng = np.random.default_rng(seed)
    height, tone = np.zeros((size, size)), np.zeros((size, size))
    for _ in range(count):
        radius = size * rng.uniform(0.055, 0.075)
        reach = int(radius)
        v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1] / radius
        dome = np.sqrt(np.clip(1 - u**2 - v**2, 0, 1)) + rng.uniform(0, 0.7)
        dome[u**2 + v**2 >= 1] = 0
        window = np.ix_(
            (np.arange(2 * reach + 1) + rng.integers(size)) % size,
            (np.arange(2 * reach + 1) + rng.integers(size)) % size,
        )
        over = dome > height[window]
        blush = np.clip(rng.uniform(0.2, 0.8) + 0.35 * (u * np.cos(radius) + v), 0, 1)
        height[window], tone[window] = (np.where(over, dome, height[window]), np.where(over, blush, tone[window]))
    shade = np.clip(height / 1.2, 0.12, 1)
    grain = fractal(size, seed, 0.4)
    return (
        picture(ramp(tone, stops) * (shade * (0.85 + 0.25 * grain))[..., None]),
        normals(height, 14.0),
        surface(0.65 + 0.1 * grain),
    )


def panes(size: int, seed: int) -> Texture:
    """Draw a window as seen by day: a dim room, a drawn curtain with folds, lace below."""
    y, x = np.mgrid[:size, :size] / size
    fold = 0.5 + 0.5 * np.sin(2 * np.pi * (11 * x + 0.4 * fractal(size, seed, 1.4, (0.3, 2.0))))
    drawn = np.abs(x - 0.5) > 0.2 + 0.12 * y
    hole = ((np.mgrid[:size, :size] % 8).max(axis=0) < 5) & (y > 0.62)
    room = ramp(fractal(size, seed + 1, 1.2), [(0.1, 0.11, 0.13), (0.2, 0.2, 0.21)])
    cloth = np.array([0.66, 0.62, 0.54]) * (0.45 + 0.5 * fold[..., None])
    lace = np.array([0.6, 0.6, 0.57]) * np.where(hole, 0.5, 1.0)[..., None]
    return picture(
        np.where((y > 0.6)[..., None], lace * (0.6 + 0.4 * fold[..., None]), np.where(drawn[..., None], cloth, room))
    )
