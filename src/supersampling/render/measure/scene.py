"""A scene's measures: how true its motion is, how smooth its lighting, how fast and how fine what it shows.

Speeds are in pixels of a 1080p target from one frame to the next, shares in [0, 1], all over a few seeded moments of walking
cameras on the test and training routes. ``None`` where a scene has nothing, or too little, to measure.
"""

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Shot
from supersampling.render.measure.look import (
    detail,
    interface_share,
    lighting_energy,
    middle,
    shadow_change,
    speeds,
)
from supersampling.render.measure.motion import (
    Disocclusion,
    agreement,
    disocclusion,
    near_agreement,
    places,
    reprojection,
)
from supersampling.render.measure.probe import Probe, seeded_shots, standing
from supersampling.scenes.manifest import MEASURES
from supersampling.scenes.scene import Scene

Measures = dict[str, float | None]

SHOTS = 6  # whole frames; shares and speeds take four times as many
FEWEST = 100  # pixels that precision and recall are taken over
FAST = 16.0  # target pixels a frame: beyond, little history is of use (see `selection.interest`)
SIDE = 768  # samples of a window whose albedo is reprojected


def measure(scene: Scene) -> Measures:
    """All measures of a scene, by the names that its manifest gives them."""
    shots = seeded_shots(scene, 4 * SHOTS)
    with Probe(scene) as probe:
        found = reprojections(probe, shots[:SHOTS])
        found |= disocclusions(probe, shots[:SHOTS])
        found |= lighting(probe, shots[:SHOTS])
        found |= shares(probe, shots) | details(probe, shots[:SHOTS])
    found["static_paths"], found["static_frames"] = standing(scene)
    found["interface_pixels"] = interface_share(scene, shots[:SHOTS])
    return {name: found[name] for name in MEASURES}


def _share(part: float, total: float) -> float | None:
    return float(part) / float(total) if total else None


def reprojections(probe: Probe, shots: list[Shot]) -> Measures:
    """Mean absolute albedo error of `motion.reprojection`; for the standing world (camera motion) and moving objects."""
    sums = np.zeros((2, 2))
    for shot in shots:
        for window in places(probe, shot, SIDE):
            error = reprojection(probe, window)
            sums += (error.still, error.moving)
    return {"reprojection_camera": _share(*sums[0]), "reprojection_objects": _share(*sums[1])}


def disocclusions(probe: Probe, shots: list[Shot]) -> Measures:
    """The share of disoccluded pixels, and precision and recall of the mask of dual motion vectors.

    Against hiding by another object (``dual_*``), the same where a mask can be right (``_able``; see
    `motion.Disocclusion`, ``beyond``), and against all that
    depth says was hidden (``_depth``); each with a tolerance of one low-resolution pixel too
    (``_near``; see `motion.near_agreement`).
    """
    frames = [disocclusion(probe, shot) for shot in shots]
    ways: dict[str, NDArray[np.int64]] = {}
    for frame in frames:
        for name, counts in _judged(frame).items():
            ways[name] = ways.get(name, np.zeros(4, np.int64)) + counts
    out: Measures = {"disoccluded_pixels": float(np.mean([f.hidden.mean() for f in frames]))}
    for name, (right, marked, found, true) in ways.items():
        out[f"dual_precision{name}"] = _share(right, marked) if marked >= FEWEST else None
        out[f"dual_recall{name}"] = _share(found, true) if true >= FEWEST else None
    return out


def _judged(frame: Disocclusion) -> dict[str, NDArray[np.int64]]:
    """Counts of `motion.agreement` by what they are against."""
    by_object = (frame.mask, frame.other, frame.nearly_other)
    out: dict[str, NDArray[np.int64]] = {}
    for name, (mask, truth, nearly), judged in (
        ("", by_object, frame.judged),
        ("_able", by_object, frame.judged & ~frame.beyond),
        ("_depth", (frame.mask, frame.hidden, frame.nearly), frame.inside),
    ):
        out[name] = agreement(mask, truth, judged)
        out[f"{name}_near"] = near_agreement(mask, truth, nearly, frame.surely, judged)
    return out


def lighting(probe: Probe, shots: list[Shot]) -> Measures:
    """Gradient energy of lighting over that of radiance (NSRD 3.1: below 1 where texture dominates), all shots together."""
    energies = np.array([lighting_energy(probe, middle(shot)) for shot in shots])
    return {"lighting_energy_ratio": _share(*energies.sum(axis=0))}


def shares(probe: Probe, shots: list[Shot]) -> Measures:
    """Median and 95th percentile of the speed, and shares of the pixels (of glossy and emissive ones: of the surfaces)."""
    seen = [speeds(probe, shot) for shot in shots]
    whole = {name: np.stack([one[name] for one in seen]) for name in seen[0]}
    solid = float(whole["solid"].sum())
    changes = np.sum([shadow_change(probe, shot) for shot in shots[: 2 * SHOTS]], axis=0)
    return {
        "speed_median": float(np.median(whole["speed"])),
        "speed_95": float(np.percentile(whole["speed"], 95)),
        "fast_pixels": float((whole["speed"] > FAST).mean()),
        "moving_pixels": float(whole["moving"].mean()),
        "glossy_pixels": _share(whole["glossy"].sum(), solid),
        "emissive_pixels": _share(whole["emissive"].sum(), solid),
        "alpha_tested_pixels": _share(whole["tested"].sum(), solid),
        "shadow_change_pixels": _share(*changes),
    }


def details(probe: Probe, shots: list[Shot]) -> Measures:
    """Shares of pixels with detail that a 270p pixel cannot hold: see `look.detail`."""
    seen = [detail(probe, shot) for shot in shots]
    solid = sum(int(one["solid"].sum()) for one in seen)
    return {
        "fine_texture_pixels": _share(sum(int(one["texture"].sum()) for one in seen), solid),
        "thin_pixels": float(np.mean([one["thin"].mean() for one in seen])),
        "moire_pixels": float(np.mean([one["beat"].mean() for one in seen])),
    }
