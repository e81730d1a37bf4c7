"""Helpers of the tests of measures: shots of a whole 1080p frame, and textures."""

import numpy as np
from analytic_scenes import scene, shift, wall

from supersampling.render.camera import Camera, Shot, Window
from supersampling.render.measure.probe import whole as whole_frame
from supersampling.scenes.scene import Material, Scene

FOCAL = 540.0 / np.tan(0.5)  # of a 1080p frame of the default camera, target pixels
MATTE = Material("matte", base_color=(0.5, 0.5, 0.5), roughness=1.0)


def noise(seed: int) -> np.ndarray:
    """Return a soft texture: 64 x 64 random colours, four texels apart, interpolated linearly."""
    coarse = np.random.default_rng(seed).uniform(30, 240, (64, 64, 3))
    position = np.arange(256) / 4
    low, part = position.astype(int), (position % 1)[:, None, None]
    rows = coarse[low] * (1 - part) + coarse[(low + 1) % 64] * part
    part = part.reshape(1, -1, 1)
    return np.round(rows[:, low] * (1 - part) + rows[:, (low + 1) % 64] * part).astype(np.uint8)


def moment(
    view: Camera,
    before: Camera | None = None,
    seconds: float = 0.0,
    previous: float = 0.0,
    window: Window | None = None,
) -> Shot:
    return Shot(view, before or view, seconds, previous, window or whole_frame(1))


def sliding(z: float, speed: float, half: float = 1.0) -> Scene:
    """A square at depth ``-z`` that moves right by ``speed`` metres a second, before a wall at 10 m."""
    materials = [Material("back", noise(1)), Material("front", noise(2))]
    meshes = [wall(-20, 20, -12, 12, -10.0), wall(-half, half, -half, half, z, 1)]
    return scene(materials, meshes, [shift(0, 0, 0), lambda t: shift(speed * t, 0, 0)])
