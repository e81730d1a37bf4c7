"""What a built-in scene shows: a file of words and measured numbers beside the scene, and whether the two agree."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Literal, cast

import yaml

from supersampling.errors import UserError

Level = Literal["dominant", "present", "absent"]
LEVELS = ("dominant", "present", "absent")

FEATURES = (
    "disocclusion", "fast_motion", "moving_objects", "glossy", "fine_texture", "text", "thin_geometry", "moire", "emissive",
    "alpha_test", "static_camera", "moving_shadows", "interface",
)  # fmt: skip

# Every measure's name and what it is; see `supersampling.render.measure`.
MEASURES = {
    "reprojection_camera": "mean absolute albedo error of the standing world, warped by its motion vectors",
    "reprojection_objects": "the same of moving objects",
    "dual_precision": "of the mask of dual motion vectors: marked pixels that another object hid",
    "dual_recall": "of the pixels that another object hid: marked ones",
    "dual_precision_near": "precision with a tolerance of one low-resolution pixel",
    "dual_recall_near": "recall, with the tolerance, of pixels hidden by more than half a low-resolution pixel",
    "dual_precision_able": "precision away from alpha-tested surfaces and from what moves by under 0.1 pixels against its hider",
    "dual_recall_able": "recall there",
    "dual_precision_able_near": "precision there with the tolerance",
    "dual_recall_able_near": "recall there with the tolerance",
    "dual_precision_depth": "precision against all that was hidden, by depth",
    "dual_recall_depth": "recall against it",
    "dual_precision_depth_near": "precision against it with the tolerance",
    "dual_recall_depth_near": "recall against it with the tolerance",
    "lighting_energy_ratio": "gradient energy of lighting over that of radiance",
    "speed_median": "median of the motion, target pixels of 1080p a frame",
    "speed_95": "its 95th percentile",
    "fast_pixels": "share of pixels that move by over 16 target pixels a frame",
    "moving_pixels": "share of pixels on moving objects",
    "disoccluded_pixels": "share of pixels that were hidden one frame before",
    "glossy_pixels": "share of surfaces with a roughness below 0.4",
    "emissive_pixels": "share of surfaces that emit",
    "alpha_tested_pixels": "share of surfaces that are alpha-tested",
    "fine_texture_pixels": "share of surfaces whose albedo varies by over 20% within a 270p pixel",
    "thin_pixels": "share of pixels on parts thinner than two 270p pixels",
    "moire_pixels": "share of pixels whose sampled albedo beats with the 270p grid",
    "shadow_change_pixels": "share of standing surfaces where a shadow changes within 0.25 s",
    "static_paths": "share of paths whose camera stands from beginning to end",
    "static_frames": "share of frames whose camera stands, of walking cameras",
    "interface_pixels": "share of pixels under elements of the interface",
}


@dataclass(frozen=True)
class Bound:
    """What a feature's words mean: ``absent`` at most so much of a measure, ``present`` more, ``dominant`` at least so much."""

    measure: str
    absent: float
    dominant: float


# Text has no measure: a reader's eye decides.
BOUNDS = {
    "disocclusion": Bound("disoccluded_pixels", 0.002, 0.015),
    "fast_motion": Bound("speed_95", 10.0, 25.0),
    "moving_objects": Bound("moving_pixels", 0.0, 0.08),
    "glossy": Bound("glossy_pixels", 0.005, 0.4),
    "fine_texture": Bound("fine_texture_pixels", 0.1, 0.25),
    "thin_geometry": Bound("thin_pixels", 0.002, 0.02),
    "moire": Bound("moire_pixels", 0.005, 0.02),
    "emissive": Bound("emissive_pixels", 0.0005, 0.03),
    "alpha_test": Bound("alpha_tested_pixels", 0.0, 0.025),
    "static_camera": Bound("static_paths", 0.0, 0.9),
    "moving_shadows": Bound("shadow_change_pixels", 0.0005, 0.02),
    "interface": Bound("interface_pixels", 0.0, 0.05),
}


@dataclass(frozen=True)
class Manifest:
    """A scene's title and description, how much of each of `FEATURES` it shows, and its `MEASURES` (none before they are taken).

    A measure is ``None`` where the scene has nothing to measure.
    """

    title: str
    about: str
    shows: Mapping[str, Level]
    measured: Mapping[str, float | None]


def load_manifest(name: str) -> Manifest:
    """The manifest of a built-in scene.

    Raises:
        UserError: there is none, or it is not as it should be.
    """
    path = files("supersampling.scenes") / f"{name}.yaml"
    if not name.isidentifier() or not path.is_file():
        raise UserError(f"Scene {name!r} has no manifest: only built-in scenes have one.")
    return parse(path.read_text(encoding="utf-8"), name)


def parse(text: str, name: str) -> Manifest:
    """The manifest written in ``text``; ``name`` is for messages.

    Raises:
        UserError: a key is missing, unknown or of another type.
    """
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise UserError(f"{name}.yaml is not YAML ({' '.join(str(error).split())}): mend it.") from None
    if not isinstance(data, dict):
        raise UserError(f"{name}.yaml holds {data!r}, not keys: give it title, about and shows.")
    _check_keys(data, ("title", "about", "shows"), ("measured",), f"{name}.yaml")
    for key in ("title", "about"):
        if not isinstance(data[key], str) or not data[key].strip():
            raise UserError(f"{name}.yaml: {key} is {data[key]!r}: write a sentence.")
    return Manifest(
        data["title"].strip(),
        data["about"].strip(),
        _shows(data["shows"], name),
        _measured(data.get("measured"), name),
    )


def _check_keys(data: dict[Any, Any], needed: tuple[str, ...], allowed: tuple[str, ...], where: str) -> None:
    for key in needed:
        if key not in data:
            raise UserError(f"{where} lacks the key {key!r}: add it.")
    for key in data:
        if key not in (*needed, *allowed):
            raise UserError(f"{where} has the unknown key {key!r}: use {', '.join((*needed, *allowed))}.")


def _shows(data: Any, name: str) -> Mapping[str, Level]:
    where = f"{name}.yaml, shows"
    if not isinstance(data, dict):
        raise UserError(f"{where} is {data!r}: give each feature's level, {', '.join(LEVELS)}.")
    _check_keys(data, FEATURES, (), where)
    for feature, level in data.items():
        if level not in LEVELS:
            raise UserError(f"{where}: {feature} is {level!r}: use {', '.join(LEVELS)}.")
    return cast(Mapping[str, Level], data)


def _measured(data: Any, name: str) -> Mapping[str, float | None]:
    if data is None:
        return {}
    where = f"{name}.yaml, measured"
    if not isinstance(data, dict):
        raise UserError(f"{where} is {data!r}: let scripts/measure_scenes.py write it.")
    _check_keys(data, tuple(MEASURES), (), where)
    for key, value in data.items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise UserError(f"{where}: {key} is {value!r}, not a number: let scripts/measure_scenes.py write it.")
    return {key: None if value is None else float(value) for key, value in data.items()}


def contradictions(manifest: Manifest) -> list[str]:
    """A sentence for each feature whose word its measure does not bear out, by `BOUNDS`."""
    out = []
    for feature, bound in BOUNDS.items():
        level, value = manifest.shows[feature], manifest.measured.get(bound.measure)
        if value is None:
            continue
        borne_out = {
            "absent": value <= bound.absent,
            "present": value > bound.absent,
            "dominant": value >= bound.dominant,
        }
        if not borne_out[level]:
            out.append(
                f"{feature} is called {level}, but {bound.measure} is {value:g} "
                f"(absent: at most {bound.absent:g}; dominant: at least {bound.dominant:g})"
            )
    return out


def with_measured(text: str, measured: Mapping[str, float | None]) -> str:
    """A manifest's text with its measures replaced, rounded to three significant digits; all else stays to the letter."""
    kept = re.sub(r"^measured:.*\n(?:[ \t].*\n|\n)*", "", text.rstrip("\n") + "\n", flags=re.MULTILINE)
    lines = (f"  {key}: {_written(measured[key])}\n" for key in MEASURES)
    return kept.rstrip("\n") + "\nmeasured:\n" + "".join(lines)


def _written(value: float | None) -> str:
    # A float's own notation has the point without which YAML 1.1 takes 1e-05 for a string.
    return "null" if value is None else f"{float(f'{value:.3g}'):.10f}".rstrip("0").rstrip(".")
