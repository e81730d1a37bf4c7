"""Metal and other industrial textures. Each returns (albedo, normal, surface) unless it says otherwise."""

from collections.abc import Sequence

import numpy as np

from supersampling.scenes.kit.textures import Field, Maps, fractal, normals, picture, ramp, surface


def _dots(size: int, count: int, radius: float, edge_only: bool = False) -> Field:
    """Return domes at the middle of ``count x count`` cells, or only on the texture's border cells."""
    y, x = np.mgrid[:size, :size] / size * count
    dome = np.clip(1 - np.hypot(x % 1 - 0.5, y % 1 - 0.5) / radius, 0, 1) ** 0.5
    if edge_only:
        border = (x < 1) | (x >= count - 1) | (y < 1) | (y >= count - 1)
        dome = dome * border
    return dome


def riveted(size: int, seed: int, paint: Sequence[Sequence[float]]) -> Maps:
    """Draw painted plates, two by two, with rivets along their edges, scratches to bare metal and rust."""
    half = size // 2
    rivet = np.tile(_dots(half, 12, 0.32, True), (2, 2))
    y, x = np.mgrid[:size, :size] % half
    seam = np.minimum(np.minimum(x, half - 1 - x), np.minimum(y, half - 1 - y)) < 2
    cloud, grain, wear = fractal(size, seed, 1.2), fractal(size, seed + 1, 0.35), fractal(size, seed + 2, 0.9)
    streak = fractal(size, seed + 3, 0.8, (0.2, 3.0))
    bare = np.clip((wear + 0.3 * rivet - 0.78) * 10, 0, 1)
    rust = np.clip((streak * 0.6 + cloud * 0.5 - 0.66) * 6, 0, 1)
    tone = np.clip(0.5 + 0.5 * (cloud - 0.5) + 0.7 * (grain - 0.5), 0, 1)
    color = ramp(tone, paint)
    color += rust[..., None] * (ramp(grain, [(0.22, 0.09, 0.04), (0.62, 0.3, 0.12)]) - color)
    color += bare[..., None] * (ramp(grain, [(0.5, 0.5, 0.5), (0.8, 0.8, 0.78)]) - color)
    color = np.where(seam[..., None], color * 0.3, color) * (0.75 + 0.35 * rivet[..., None])
    metallic = bare * (1 - rust)
    return (
        picture(color),
        normals(rivet + 0.12 * grain - 0.6 * seam, 6.0),
        surface(0.4 + 0.3 * grain + 0.3 * rust, metallic),
    )


def tread(size: int, seed: int) -> Maps:
    """Draw a checker plate: raised bars in alternating directions, worn bright."""
    y, x = np.mgrid[:size, :size] / size * 12
    odd = (np.floor(x) + np.floor(y)) % 2 > 0.5
    u, v = x % 1 - 0.5, y % 1 - 0.5
    a, b = np.where(odd, u + v, u - v) / 1.414, np.where(odd, u - v, u + v) / 1.414
    bar = np.clip(1.3 - np.hypot(a / 0.44, b / 0.13), 0, 1)
    cloud, grain = fractal(size, seed, 1.1), fractal(size, seed + 1, 0.3)
    tone = np.clip(0.25 + 0.4 * bar + 0.5 * (cloud - 0.5) + 0.45 * (grain - 0.5), 0, 1)
    color = ramp(tone, [(0.2, 0.19, 0.18), (0.5, 0.49, 0.47), (0.85, 0.84, 0.8)])
    return picture(color), normals(bar + 0.08 * grain, 7.0), surface(0.3 + 0.4 * cloud, 0.35 + 0.5 * bar)


def brushed(size: int, seed: int, stops: Sequence[Sequence[float]], metallic: float = 1.0) -> Maps:
    """Draw machined metal: fine lines along u, dents and oil stains."""
    line, cloud = fractal(size, seed, 0.3, (1.0, 12.0)), fractal(size, seed + 1, 1.2)
    grain = fractal(size, seed + 2, 0.3)
    oil = np.clip((fractal(size, seed + 3, 1.0) - 0.7) * 6, 0, 1)
    tone = np.clip(0.4 * line + 0.35 * cloud + 0.3 * grain, 0, 1)
    color = ramp(tone, stops) * (1 - 0.6 * oil[..., None])
    return (
        picture(color),
        normals(0.6 * line + 0.4 * grain, 2.5),
        surface(0.25 + 0.35 * line + 0.2 * cloud, metallic * (1 - 0.5 * oil)),
    )


def corrugated(size: int, seed: int, paint: Sequence[Sequence[float]], waves: int = 12) -> Maps:
    """Draw a corrugated sheet, waves along v, with bolts, rust and streaks."""
    x = np.mgrid[:size, :size][1] / size * waves
    wave = 0.5 + 0.5 * np.sin(2 * np.pi * x)
    bolt = _dots(size, waves, 0.14) * (np.mgrid[:size, :size][0] % (size // 2) < size // waves)
    grain, cloud, streak = (
        fractal(size, seed, 0.35),
        fractal(size, seed + 1, 1.1),
        fractal(size, seed + 2, 0.8, (0.15, 3.0)),
    )
    rust = np.clip((0.6 * streak + 0.5 * cloud - 0.62) * 5, 0, 1)
    color = ramp(np.clip(0.3 + 0.3 * wave + 0.55 * (grain - 0.3), 0, 1), paint)
    color += rust[..., None] * (ramp(grain, [(0.2, 0.09, 0.05), (0.58, 0.29, 0.13)]) - color)
    color *= 1 - 0.5 * bolt[..., None]
    return picture(color), normals(wave * 3 + bolt + 0.12 * grain, 5.0), surface(0.45 + 0.4 * rust, 0.0)


def concrete(size: int, seed: int) -> Maps:
    """Draw floor slabs with cracks, aggregate and oil stains."""
    grain, cloud, oil = fractal(size, seed, 0.25), fractal(size, seed + 1, 1.2), fractal(size, seed + 2, 1.3)
    cracks = np.abs(fractal(size, seed + 3, 1.3) - 0.5) < 0.006
    y, x = np.mgrid[:size, :size]
    joint = (x % (size // 2) < 3) | (y % (size // 2) < 3)
    speck = fractal(size, seed + 4, 0.5)
    tone = np.clip(0.5 + 0.55 * (grain - 0.5) + 0.5 * (cloud - 0.5), 0, 1)
    color = ramp(tone, [(0.27, 0.26, 0.25), (0.52, 0.5, 0.47), (0.74, 0.71, 0.66)])
    color = np.where((speck > 0.86)[..., None], color * 1.35, np.where((speck < 0.12)[..., None], color * 0.6, color))
    stain = np.clip((oil - 0.68) * 5, 0, 1)
    color = np.where((cracks | joint)[..., None], color * 0.3, color * (1 - 0.55 * stain[..., None]))
    return picture(color), normals(0.25 * grain - 0.7 * (cracks | joint), 4.0), surface(0.85 - 0.55 * stain)


def hazard(size: int, seed: int, stripes: int = 4) -> Maps:
    """Draw diagonal black and yellow stripes, worn."""
    y, x = np.mgrid[:size, :size] / size
    dark = ((x + y) * stripes) % 1 < 0.5
    wear, grain = fractal(size, seed, 0.8), fractal(size, seed + 1, 0.3)
    color = np.where(dark[..., None], [0.09, 0.09, 0.1], [0.93, 0.71, 0.08]) * (0.65 + 0.6 * grain[..., None])
    color = np.where((wear > 0.75)[..., None], ramp(grain, [(0.3, 0.28, 0.25), (0.62, 0.6, 0.56)]), color)
    return picture(color), normals(0.3 * grain - 0.3 * (wear > 0.75), 4.0), surface(0.45 + 0.4 * wear)


def embers(size: int, seed: int) -> Maps:
    """Draw glowing coals: dark crust over orange cracks; the emission mask is in the surface map."""
    crust, glow = fractal(size, seed, 0.9), fractal(size, seed + 1, 1.1)
    vein = np.clip(1.2 - np.abs(crust - 0.5) * 5, 0, 1)
    heat = np.clip(0.25 + 0.75 * vein * (0.4 + glow), 0, 1)
    color = ramp(heat, [(0.12, 0.02, 0.0), (0.8, 0.18, 0.02), (1.0, 0.55, 0.1), (1.0, 0.85, 0.45)])
    return picture(color), normals(1 - vein, 6.0), surface(0.9, 0.0, 0.12 + 0.88 * heat**1.5)
