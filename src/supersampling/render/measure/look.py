"""What a scene looks like, in numbers: shares of pixels, speeds, fine detail, and how smooth its lighting is."""

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from supersampling.ops.demodulate import MIN_MATERIAL, demodulate
from supersampling.render.camera import Matrix, Shot
from supersampling.render.measure.probe import FRAME, Mask, Probe, interface_drawn, shifted, whole
from supersampling.render.renderer import Image
from supersampling.scenes.scene import Scene

SCALE = 4
GLOSSY = 0.4  # roughness below which a surface counts as glossy
CONTRAST = 0.2  # of the mean: standard deviation of albedo in 4 x 4 target pixels that counts as fine texture
BEAT = 0.08  # of the mean: error of albedo averaged over 15 x 15 low-resolution pixels that counts as moire
SHADOW_SECONDS = 0.25
_VISIBLE = 2.0 / 255.0
_JUMP = 0.02  # of the inverse depth


def speeds(probe: Probe, shot: Shot) -> dict[str, NDArray]:
    """Of a whole frame's low-resolution pixels: ``speed``, the length of the motion in target pixels, and what they show.

    The others are masks: ``solid`` surfaces, and on them ``moving`` objects, ``glossy`` ones, ``emissive`` ones,
    ``tested``, the alpha-tested ones.
    """
    names = frozenset({"motion", "object_id", "roughness", "emission"})
    low = probe.renderer.low(shot, SCALE, (0.0, 0.0), 0.0, names)
    ids = low["object_id"][..., 0].astype(np.intp)
    solid = ids > 0
    return {
        "speed": np.linalg.norm(low["motion"].astype(np.float64) * FRAME, axis=-1),
        "solid": solid,
        "moving": probe.moves[ids],
        "glossy": solid & (low["roughness"][..., 0] < GLOSSY),
        "emissive": solid & (low["emission"].mean(axis=-1) > 1e-3),
        "tested": probe.tested[ids],
    }


def interface_share(scene: Scene, shots: list[Shot]) -> float:
    """The share of pixels that show an element of the interface."""
    if not any(m.interface for m in scene.materials):
        return 0.0
    with Probe(interface_drawn(scene)) as drawn:
        materials = [scene.materials[scene.meshes[o.meshes[0]].material] for o in drawn.scene.objects]
        marked = np.array([False, *(m.interface for m in materials)])
        shown = [
            drawn.renderer.low(shot, SCALE, (0.0, 0.0), 0.0, frozenset({"object_id"}))["object_id"] for shot in shots
        ]
    return float(np.mean([marked[ids.astype(np.intp)].mean() for ids in shown]))


def shadow_change(probe: Probe, shot: Shot) -> tuple[int, int]:
    """Standing pixels whose displayed colour changes by over 2/255 within 0.25 s before a camera that stands, and all standing.

    Nothing else changes there: lights and materials are constant, so it is shadows.
    """
    names, (now, then) = frozenset({"color", "object_id", "depth"}), _standing(shot)
    a = probe.renderer.low(now, SCALE, (0.0, 0.0), 0.0, names)
    b = probe.renderer.low(then, SCALE, (0.0, 0.0), 0.0, names)
    ids = a["object_id"][..., 0].astype(np.intp)
    still = (ids > 0) & ~probe.moves[ids] & (a["object_id"] == b["object_id"])[..., 0]
    still &= (a["depth"] == b["depth"])[..., 0]
    changed = np.abs(a["color"] - b["color"]).max(axis=-1) > _VISIBLE
    return int((changed & still).sum()), int(still.sum())


def _standing(shot: Shot) -> tuple[Shot, Shot]:
    camera, seconds = shot.camera, shot.seconds
    earlier = seconds - SHADOW_SECONDS
    return (
        Shot(camera, camera, seconds, seconds, shot.window),
        Shot(camera, camera, earlier, earlier, shot.window),
    )


def detail(probe: Probe, shot: Shot) -> dict[str, Mask]:
    """What a low-resolution pixel cannot hold, as masks of a whole frame.

    ``texture`` (low-resolution): the albedo of its 4 x 4 target pixels, which all lie on one surface, varies by over 20%.
    ``thin`` (target pixels): a part in front of what is 4 target pixels to either side of it, or above and below.
    ``beat`` (low-resolution): albedo sampled once a pixel, at the mip level of the target, is off by over 8% even when
    averaged over 15 x 15 pixels: a pattern that beats with the pixel grid. ``solid`` (low-resolution): surfaces alone.
    """
    full = probe.samples(shot, 0.0, "albedo", "depth", "object_id")
    ids, inverse = full["object_id"][..., 0], probe.inverse_depth(full["depth"])
    grey = full["albedo"].astype(np.float64).mean(axis=-1)
    thin = np.zeros(ids.shape, dtype=bool)
    for before, after in shifted(inverse, SCALE):
        thin |= inverse > (1.0 + _JUMP) * np.maximum(before, after)
    first, ahead = _blocks(ids), _blocks(inverse)
    one = (first.min(axis=-1) == first.max(axis=-1)) & (first.min(axis=-1) > 0)
    one &= ahead.max(axis=-1) < (1.0 + _JUMP) * ahead.min(axis=-1)
    mean, spread = _blocks(grey).mean(axis=-1), _blocks(grey).std(axis=-1)
    names = frozenset({"albedo"})
    sampled = probe.renderer.low(shot, SCALE, (0.0, 0.0), -float(np.log2(SCALE)), names)["albedo"].mean(axis=-1)
    off = np.abs(uniform_filter(sampled.astype(np.float64) - mean, 15))
    return {
        "texture": one & (spread > CONTRAST * mean),
        "thin": thin,
        "beat": off > BEAT * np.maximum(uniform_filter(mean, 15), 1e-3),  # the sky has no albedo
        "solid": first.min(axis=-1) > 0,
    }


def _blocks(image: NDArray) -> NDArray:
    """``(H, W)`` to ``(H / 4, W / 4, 16)``."""
    height, width = image.shape[0] // SCALE, image.shape[1] // SCALE
    parts = image.reshape(height, SCALE, width, SCALE).swapaxes(1, 2)
    return parts.reshape(height, width, SCALE * SCALE)


def gradient_energy(values: Matrix, chosen: Mask) -> float:
    """Mean of the squared differences of ``log(1 + v / mean)`` between neighbours ``(h, w, C)`` that are both ``chosen``.

    The same for any multiple of ``v``; the logarithm keeps a few highlights from deciding. 0 where all is black.
    """
    mean = values[chosen].mean() if chosen.any() else 0.0
    if mean <= 0.0:
        return 0.0
    scaled = np.log1p(np.where(chosen[..., None], values, 0.0) / mean)
    total, count = 0.0, 0
    for axis in (0, 1):
        both = chosen.take(range(1, chosen.shape[axis]), axis) & chosen.take(range(chosen.shape[axis] - 1), axis)
        total += float((np.diff(scaled, axis=axis)[both] ** 2).sum())
        count += int(both.sum()) * values.shape[-1]
    return total / max(count, 1)


def lighting_energy(probe: Probe, shot: Shot, samples: int = 2) -> tuple[float, float]:
    """Gradient energy of lighting and of radiance over the shot's window of target pixels, on surfaces that do not emit."""
    names = frozenset({"target_radiance", "high_material", "high_emission"})
    high = probe.renderer.high(shot, samples, 0.0, names)
    radiance, material, emission = (high[n] for n in ("target_radiance", "high_material", "high_emission"))
    lighting = demodulate(*(_planes(b) for b in (radiance, material, emission)))[0].permute(1, 2, 0).numpy()
    chosen = (emission.max(axis=-1) == 0.0) & (material.min(axis=-1) >= MIN_MATERIAL)
    return (
        gradient_energy(lighting.astype(np.float64), chosen),
        gradient_energy(radiance.astype(np.float64), chosen),
    )


def _planes(image: Image) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1)[None]


def middle(shot: Shot, width: int = 512, height: int = 288) -> Shot:
    """The middle of a whole 1080p frame, in target pixels."""
    x, y = (FRAME[0] - width) // 2, (FRAME[1] - height) // 2
    return replace(shot, window=replace(whole(1), x=x, y=y, width=width, height=height))
