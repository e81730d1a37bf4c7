"""Measures of a scene's appearance: shares of pixels, speeds, fine detail, and smoothness of the lighting."""

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
# Standard deviation over mean of the albedo in 4 x 4 target pixels, above which it counts as fine texture.
CONTRAST = 0.2
# Relative error of the albedo averaged over 15 x 15 low-resolution pixels, above which it counts as moire.
BEAT = 0.08
SHADOW_SECONDS = 0.25
_VISIBLE = 2.0 / 255.0
_JUMP = 0.02  # of the inverse depth


def speeds(probe: Probe, shot: Shot) -> dict[str, NDArray]:
    """Return the ``speed`` of a whole frame's low-resolution pixels (length of the motion in target pixels) and masks.

    The masks are ``solid`` (surfaces) and, among them, ``moving`` objects, ``glossy``, ``emissive`` and ``tested``
    (alpha-tested) surfaces.
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
    """Return the share of pixels that show an element of the interface."""
    if not any(m.interface for m in scene.materials):
        return 0.0
    with Probe(interface_drawn(scene)) as drawn:
        materials = [scene.materials[scene.meshes[o.meshes[0]].material] for o in drawn.scene.objects]
        marked = np.array([False, *(m.interface for m in materials)])
        names = frozenset({"object_id"})
        frames = [drawn.renderer.low(shot, SCALE, (0.0, 0.0), 0.0, names)["object_id"] for shot in shots]
    return float(np.mean([marked[ids.astype(np.intp)].mean() for ids in frames]))


def shadow_change(probe: Probe, shot: Shot) -> tuple[int, int]:
    """Return the number of static pixels whose displayed colour changes by over 2/255, and of all static pixels.

    The change is over 0.25 s before a camera that stands still. Lights and materials are constant, so that only shadows
    change there.
    """
    names, camera, earlier = frozenset({"color", "object_id", "depth"}), shot.camera, shot.seconds - SHADOW_SECONDS
    now = Shot(camera, camera, shot.seconds, shot.seconds, shot.window)
    before = Shot(camera, camera, earlier, earlier, shot.window)
    a = probe.renderer.low(now, SCALE, (0.0, 0.0), 0.0, names)
    b = probe.renderer.low(before, SCALE, (0.0, 0.0), 0.0, names)
    ids = a["object_id"][..., 0].astype(np.intp)
    still = (ids > 0) & ~probe.moves[ids] & (a["object_id"] == b["object_id"])[..., 0]
    still &= (a["depth"] == b["depth"])[..., 0]
    changed = np.abs(a["color"] - b["color"]).max(axis=-1) > _VISIBLE
    return int((changed & still).sum()), int(still.sum())


def detail(probe: Probe, shot: Shot) -> dict[str, Mask]:
    """Return masks of detail that low-resolution pixels cannot represent, for a whole frame.

    ``texture`` (low resolution): the pixel's 4 x 4 target pixels lie on one surface and their albedo varies by over
    20%. ``thin`` (target pixels): the pixel is in front of both pixels that are 4 target pixels to its sides, or above
    and below. ``beat`` (low resolution): albedo with one sample per pixel, at the mip level of the target, is off by
    over 8% even after averaging over 15 x 15 pixels, because a pattern beats with the pixel grid. ``solid`` (low
    resolution): the pixel shows a surface.
    """
    full = probe.samples(shot, 0.0, "albedo", "depth", "object_id")
    ids, inverse = full["object_id"][..., 0], probe.inverse_depth(full["depth"])
    grey = full["albedo"].astype(np.float64).mean(axis=-1)
    thin = np.zeros(ids.shape, dtype=bool)
    for before, after in shifted(inverse, SCALE):
        thin |= inverse > (1.0 + _JUMP) * np.maximum(before, after)
    first, ahead = _blocks(ids), _blocks(inverse)
    single = (first.min(axis=-1) == first.max(axis=-1)) & (first.min(axis=-1) > 0)
    single &= ahead.max(axis=-1) < (1.0 + _JUMP) * ahead.min(axis=-1)
    mean, spread = _blocks(grey).mean(axis=-1), _blocks(grey).std(axis=-1)
    names = frozenset({"albedo"})
    sampled = probe.renderer.low(shot, SCALE, (0.0, 0.0), -float(np.log2(SCALE)), names)["albedo"].mean(axis=-1)
    off = np.abs(uniform_filter(sampled.astype(np.float64) - mean, 15))
    return {
        "texture": single & (spread > CONTRAST * mean),
        "thin": thin,
        "beat": off > BEAT * np.maximum(uniform_filter(mean, 15), 1e-3),  # the sky has no albedo
        "solid": first.min(axis=-1) > 0,
    }


def _blocks(image: NDArray) -> NDArray:
    """Rearrange ``(H, W)`` to ``(H / 4, W / 4, 16)``."""
    height, width = image.shape[0] // SCALE, image.shape[1] // SCALE
    parts = image.reshape(height, SCALE, width, SCALE).swapaxes(1, 2)
    return parts.reshape(height, width, SCALE * SCALE)


def gradient_energy(values: Matrix, selected: Mask) -> float:
    """Return the mean squared difference of ``log(1 + v / mean)`` between ``selected`` neighbours ``(h, w, C)``.

    It does not change if ``v`` is scaled; the logarithm limits the influence of a few highlights. 0 if all is black.
    """
    mean = values[selected].mean() if selected.any() else 0.0
    if mean <= 0.0:
        return 0.0
    scaled = np.log1p(np.where(selected[..., None], values, 0.0) / mean)
    total, count = 0.0, 0
    for axis in (0, 1):
        length = selected.shape[axis]
        pairs = selected.take(range(1, length), axis) & selected.take(range(length - 1), axis)
        total += float((np.diff(scaled, axis=axis)[pairs] ** 2).sum())
        count += int(pairs.sum()) * values.shape[-1]
    return total / max(count, 1)


def lighting_energy(probe: Probe, shot: Shot, samples: int = 2) -> tuple[float, float]:
    """Return the gradient energies of lighting and of radiance in the shot's window, on surfaces that do not emit."""
    names = frozenset({"target_radiance", "high_material", "high_emission"})
    high = probe.renderer.high(shot, samples, 0.0, names)
    radiance, material, emission = (high[n] for n in ("target_radiance", "high_material", "high_emission"))
    lighting = demodulate(*(_planes(b) for b in (radiance, material, emission)))[0].permute(1, 2, 0).numpy()
    selected = (emission.max(axis=-1) == 0.0) & (material.min(axis=-1) >= MIN_MATERIAL)
    energy = gradient_energy(lighting.astype(np.float64), selected)
    return energy, gradient_energy(radiance.astype(np.float64), selected)


def _planes(image: Image) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1)[None]


def middle(shot: Shot, width: int = 512, height: int = 288) -> Shot:
    """Return the shot of the middle of a whole 1080p frame, in target pixels."""
    x, y = (FRAME[0] - width) // 2, (FRAME[1] - height) // 2
    return replace(shot, window=replace(whole(1), x=x, y=y, width=width, height=height))
