"""Light of a track: sun, sky colours from its sky box, and the strongest lamps along the routes."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.scene import PointLight, Route, Sky, Sun
from supersampling.scenes.stk.data import Assets
from supersampling.scenes.stk.images import linear, read_image
from supersampling.scenes.stk.nodes import Lamp
from supersampling.scenes.stk.placement import MIRROR, triple

Rgb = NDArray[np.float32]
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
# pointlight.frag: irradiance / pi = 20 energy / (1 + d^2), fading to zero at the light's distance.
_LAMP_STRENGTH = 20.0
_MOST_LAMPS = 32
_BRIGHTEST_AMBIENT = 8.0
_BOUNCED = 1.5  # the sky box lacks the light that the ground reflects, about half as much again
_SIDE = 128


def read_sun(scene: Element) -> Sun | None:
    """Return the ``<sun>``; None for a track without one, or with a black one."""
    node = scene.find("sun")
    if node is None:
        return None
    x, y, z = triple(node.get("xyz"), (0.0, 100.0, 0.0))
    toward = MIRROR[:3, :3] @ np.array([x, y, z])
    length = float(np.linalg.norm(toward))
    color = np.array(triple(node.get("sun-diffuse"), (0.0, 0.0, 0.0))) / 255.0
    # A sun at the origin has no direction.
    if length < 1e-6 or color.max() <= 0.0:
        return None
    return Sun(_rgb(toward / length), _rgb(color))


def read_sky(scene: Element, assets: Assets) -> Sky:
    """Return the sky box's mean zenith, horizon and ground; ``ambient`` scales them to the lighting box."""
    box = _box(scene, assets, "texture")
    if box is None:
        plain = linear(np.array(_plain(scene)) / 255.0)
        return Sky(_rgb(plain), _rgb(plain), _rgb(plain * 0.5), 1.0)
    zenith = box[0].mean(axis=(0, 1))
    sides = np.stack(box[2:])
    horizon = sides[:, int(0.38 * _SIDE) : _SIDE // 2].mean(axis=(0, 1, 2))
    below = sides[:, _SIDE // 2 :].mean(axis=(0, 1, 2))
    ground = 0.5 * (below + box[1].mean(axis=(0, 1)))
    lighting = _box(scene, assets, "sh-texture")
    mean = _mean_luminance(box)
    node = scene.find("sun")
    flat = triple(node.get("ambient") if node is not None else None, (120.0, 120.0, 120.0))
    # At least a third of the plain ambient colour, so that caves and night tracks with dark boxes are not black.
    lit = max(_mean_luminance(lighting or box), 0.3 * _luminance(np.array(flat) / 255.0))
    ambient = float(np.clip(lit / max(mean, 1e-4), _BOUNCED, _BRIGHTEST_AMBIENT))
    return Sky(_rgb(_paler(zenith)), _rgb(_paler(horizon)), _rgb(_paler(ground)), ambient)


def sky_files(scene: Element, assets: Assets) -> list[Path]:
    """Return the images that the sky is averaged from."""
    node = scene.find("sky-box")
    names = [] if node is None else node.get("texture", "").split() + node.get("sh-texture", "").split()
    return [path for name in names if (path := assets.texture(name, assets.track))]


def exposure_for(sun: Sun | None, sky: Sky) -> float:
    """Return an exposure that gives grey surfaces in the open a middle tone, and leaves night darker than day."""
    direct = 0.0 if sun is None else _luminance(np.array(sun.radiance)) * max(sun.direction[1], 0.2)
    around = sky.ambient * _luminance(0.5 * np.array(sky.zenith) + 0.5 * np.array(sky.horizon))
    return float(np.clip((1.0 / max(direct + around, 1e-3)) ** 0.75, 0.7, 4.0))


def nearby_lamps(lamps: Sequence[Lamp], routes: Sequence[Route]) -> list[PointLight]:
    """Return the strongest lamps that reach a route, without lamps close to a stronger one."""
    path = np.concatenate([route.points for route in routes])
    lights: list[PointLight] = []
    for lamp in sorted(lamps, key=lambda x: -x.energy * x.distance * max(x.color)):
        position = _position(lamp)
        gap = float(np.linalg.norm(path - position, axis=1).min())
        crowded = any(np.linalg.norm(position - np.array(x.position)) < 0.25 * x.radius for x in lights)
        if gap < lamp.distance and not crowded and lamp.distance > 2.0:
            strength = _LAMP_STRENGTH * lamp.energy * np.array(lamp.color) / 255.0
            lights.append(PointLight(_rgb(position), _rgb(strength), lamp.distance, shadowed=False))
        if len(lights) == _MOST_LAMPS:
            break
    return lights


def _position(lamp: Lamp) -> NDArray[np.float64]:
    out = MIRROR
    for placement in lamp.chain:
        out = out @ placement.matrix()
    return out[:3, 3]


def _box(scene: Element, assets: Assets, attribute: str) -> list[Rgb] | None:
    """Return six linear images ``(128, 128, 3)``: top, bottom and four sides; None unless all exist."""
    node = scene.find("sky-box")
    names = [] if node is None else node.get(attribute, "").split()
    paths = [assets.texture(name, assets.track) for name in names]
    if len(paths) != 6:
        return None
    images = []
    for path in paths:
        if path is None:
            return None
        image = read_image(path, False, _SIDE)
        rows = np.arange(_SIDE) * image.shape[0] // _SIDE
        columns = np.arange(_SIDE) * image.shape[1] // _SIDE
        images.append(linear(image[rows][:, columns] / 255.0))
    return images


def _paler(color: NDArray[np.floating]) -> NDArray[np.floating]:
    """Mix a third of grey in: the sky lights the shade, and its pure blue would turn a brown road black."""
    return (2.0 * color + _luminance(color)) / 3.0


def _mean_luminance(box: list[Rgb]) -> float:
    return _luminance(np.mean([face.mean(axis=(0, 1)) for face in box], axis=0))


def _plain(scene: Element) -> tuple[float, float, float]:
    node = scene.find("sky-color")
    return triple(node.get("rgb") if node is not None else None, (120.0, 160.0, 220.0))


def _luminance(color: NDArray[np.floating]) -> float:
    return float(color @ _LUMINANCE)


def _rgb(color: NDArray[np.floating]) -> tuple[float, float, float]:
    return (float(color[0]), float(color[1]), float(color[2]))
