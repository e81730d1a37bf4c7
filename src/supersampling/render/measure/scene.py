"""Measures of a scene: accuracy of its motion vectors, smoothness of its lighting, speeds and fine detail.

Speeds are in pixels of a 1080p target per frame, shares in [0, 1], all over a few seeded moments of walking cameras on
the test and training routes. A measure is None if the scene has nothing, or too little, to measure.
"""

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Shot
from supersampling.render.measure.disocclusion import Disocclusion, agreement, disocclusion, near_agreement
from supersampling.render.measure.look import detail, interface_share, lighting_energy, middle, shadow_change, speeds
from supersampling.render.measure.motion import places, reprojection
from supersampling.render.measure.probe import Probe, seeded_shots, standing
from supersampling.scenes.manifest import MEASURES
from supersampling.scenes.scene import Scene

Measures = dict[str, float | None]

SHOTS = 6  # whole frames; shares and speeds use four times as many
FEWEST = 100  # pixels that precision and recall need
FAST = 16.0  # target pixels per frame; the history is of little use above (see `selection.interest`)
SIDE = 768  # side in samples of a window whose albedo is reprojected


def measure(scene: Scene) -> Measures:
    """Return all measures of a scene by their names in its manifest."""
    shots = seeded_shots(scene, 4 * SHOTS)
    with Probe(scene) as probe:
        measures = reprojections(probe, shots[:SHOTS])
        measures |= disocclusions(probe, shots[:SHOTS])
        measures |= lighting(probe, shots[:SHOTS])
        measures |= shares(probe, shots) | details(probe, shots[:SHOTS])
    measures["static_paths"], measures["static_frames"] = standing(scene)
    measures["interface_pixels"] = interface_share(scene, shots[:SHOTS])
    return {name: measures[name] for name in MEASURES}


def _share(part: float, total: float) -> float | None:
    return float(part) / float(total) if total else None


def reprojections(probe: Probe, shots: list[Shot]) -> Measures:
    """Return the mean absolute albedo error of `motion.reprojection`, for the static world and for moving objects."""
    sums = np.zeros((2, 2))
    for shot in shots:
        for window in places(probe, shot, SIDE):
            error = reprojection(probe, window)
            sums += (error.still, error.moving)
    return {"reprojection_camera": _share(*sums[0]), "reprojection_objects": _share(*sums[1])}


def disocclusions(probe: Probe, shots: list[Shot]) -> Measures:
    """Return the share of disoccluded pixels, and precision and recall of the mask of dual motion vectors.

    They are relative to hiding by another object (``dual_*``), the same only where a mask can be right (``_able``; see
    ``beyond`` of `Disocclusion`), and relative to all pixels hidden by depth (``_depth``); each also with a
    tolerance of one low-resolution pixel (``_near``; see `near_agreement`).
    """
    frames = [disocclusion(probe, shot) for shot in shots]
    totals: dict[str, NDArray[np.int64]] = {}
    for frame in frames:
        for name, counts in agreements(frame).items():
            totals[name] = totals.get(name, np.zeros(4, np.int64)) + counts
    out: Measures = {"disoccluded_pixels": float(np.mean([f.hidden.mean() for f in frames]))}
    for name, (right, marked, matched, true) in totals.items():
        out[f"dual_precision{name}"] = _share(right, marked) if marked >= FEWEST else None
        out[f"dual_recall{name}"] = _share(matched, true) if true >= FEWEST else None
    return out


def agreements(frame: Disocclusion) -> dict[str, NDArray[np.int64]]:
    """Return the counts of `agreement` for each suffix that `disocclusions` documents."""
    by_object = (frame.mask, frame.by_object, frame.nearly_by_object)
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
    """Return the gradient energy of lighting over that of radiance (NSRD 3.1: below 1 if texture dominates)."""
    energies = np.array([lighting_energy(probe, middle(shot)) for shot in shots])
    return {"lighting_energy_ratio": _share(*energies.sum(axis=0))}


def shares(probe: Probe, shots: list[Shot]) -> Measures:
    """Return the median and 95th percentile of the speed, and shares of pixels.

    Shares of glossy, emissive and alpha-tested pixels are relative to all pixels that show surfaces.
    """
    frames = [speeds(probe, shot) for shot in shots]
    whole = {name: np.stack([frame[name] for frame in frames]) for name in frames[0]}
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
    """Return shares of pixels with detail that a 270p pixel cannot represent: see `look.detail`."""
    frames = [detail(probe, shot) for shot in shots]
    solid = sum(int(frame["solid"].sum()) for frame in frames)
    return {
        "fine_texture_pixels": _share(sum(int(frame["texture"].sum()) for frame in frames), solid),
        "thin_pixels": float(np.mean([frame["thin"].mean() for frame in frames])),
        "moire_pixels": float(np.mean([frame["beat"].mean() for frame in frames])),
    }
