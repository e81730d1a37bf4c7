"""Manifest of a built-in scene: a file of words and measured numbers beside the scene, and whether the two agree."""

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
    "disocclusion",
    "fast_motion",
    "moving_objects",
    "glossy",
    "fine_texture",
    "text",
    "thin_geometry",
    "moire",
    "emissive",
    "alpha_test",
    "static_camera",
    "moving_shadows",
    "interface",
)

# Name and meaning of every measure; see `supersampling.render.measure`.
MEASURES = {
    "reprojection_camera": "mean absolute albedo error of the standing world, warped by its motion vectors",
    "reprojection_objects": "the same for moving objects",
    "dual_precision": "share of the pixels marked by the mask of dual motion vectors that another object hid",
    "dual_recall": "share of the pixels that another object hid that the mask marks",
    "dual_precision_near": "precision with a tolerance of one low-resolution pixel",
    "dual_recall_near": "recall, with the tolerance, of pixels hidden by more than half a low-resolution pixel",
    "dual_precision_able": "precision away from alpha-tested surfaces and from pixels that move by under 0.1 pixels "
    "relative to the object that hides them",
    "dual_recall_able": "recall there",
    "dual_precision_able_near": "precision there with the tolerance",
    "dual_recall_able_near": "recall there with the tolerance",
    "dual_precision_depth": "precision against all hidden pixels, found by depth",
    "dual_recall_depth": "recall against it",
    "dual_precision_depth_near": "precision against it with the tolerance",
    "dual_recall_depth_near": "recall against it with the tolerance",
    "lighting_energy_ratio": "gradient energy of lighting over that of radiance",
    "speed_median": "median of the motion, target pixels of 1080p per frame",
    "speed_95": "its 95th percentile",
    "fast_pixels": "share of pixels that move by over 16 target pixels per frame",
    "moving_pixels": "share of pixels on moving objects",
    "disoccluded_pixels": "share of pixels that were hidden one frame before",
    "glossy_pixels": "share of surfaces with a roughness below 0.4",
    "emissive_pixels": "share of surfaces that emit",
    "alpha_tested_pixels": "share of surfaces that are alpha-tested",
    "fine_texture_pixels": "share of surfaces whose albedo varies by over 20% within a 270p pixel",
    "thin_pixels": "share of pixels on parts thinner than two 270p pixels",
    "moire_pixels": "share of pixels whose sampled albedo beats with the 270p grid",
    "shadow_change_pixels": "share of standing surfaces where a shadow changes within 0.25 s",
    "static_paths": "share of paths whose camera stands throughout",
    "static_frames": "share of frames whose camera stands, of walking cameras",
    "interface_pixels": "share of pixels under elements of the interface",
}


@dataclass(frozen=True)
class Bound:
    """Meaning of a feature's words: ``absent`` is at most the first number, ``dominant`` at least the second one.

    ``present`` is more than ``absent``.
    """

    measure: str
    absent: float
    dominant: float


# Text has no measure: the author decides by eye.
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
    """Title and description of a scene, the level of each of `FEATURES`, and its `MEASURES` (empty until measured).

    A measure is ``None`` if the scene has nothing to measure.
    """

    title: str
    about: str
    shows: Mapping[str, Level]
    measured: Mapping[str, float | None]


def load_manifest(name: str) -> Manifest:
    """Return the manifest of a built-in scene.

    Raises:
        UserError: the manifest does not exist or is invalid.
    """
    path = files("supersampling.scenes") / f"{name}.yaml"
    if not name.isidentifier() or not path.is_file():
        raise UserError(f"Scene {name} has no manifest: name a built-in scene.")
    return parse(path.read_text(encoding="utf-8"), name)


def parse(text: str, name: str) -> Manifest:
    """Return the manifest written in ``text``; ``name`` is for messages.

    Raises:
        UserError: a key is missing or unknown, or its value has the wrong type.
    """
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise UserError(f"{name}.yaml is not YAML ({' '.join(str(error).split())}): fix its syntax.") from None
    if not isinstance(data, dict):
        raise UserError(f"{name}.yaml contains {data} instead of keys: write title, about and shows.")
    _check_keys(data, ("title", "about", "shows"), ("measured",), f"{name}.yaml")
    for key in ("title", "about"):
        if not isinstance(data[key], str) or not data[key].strip():
            raise UserError(f"Invalid {key}={data[key]} in {name}.yaml: write a sentence.")
    return Manifest(
        data["title"].strip(), data["about"].strip(), _shows(data["shows"], name), _measured(data.get("measured"), name)
    )


def _check_keys(data: dict[Any, Any], required: tuple[str, ...], optional: tuple[str, ...], location: str) -> None:
    for key in required:
        if key not in data:
            raise UserError(f"Missing key {key!r} in {location}: add it.")
    for key in data:
        if key not in (*required, *optional):
            raise UserError(f"Unknown key {key!r} in {location}: use {', '.join((*required, *optional))}.")


def _shows(data: Any, name: str) -> Mapping[str, Level]:
    if not isinstance(data, dict):
        raise UserError(f"Invalid shows={data} in {name}.yaml: write the level of each feature ({', '.join(LEVELS)}).")
    _check_keys(data, FEATURES, (), f"{name}.yaml, shows")
    for feature, level in data.items():
        if level not in LEVELS:
            raise UserError(f"Invalid {feature}={level} in {name}.yaml: use {', '.join(LEVELS)}.")
    return cast(Mapping[str, Level], data)


def _measured(data: Any, name: str) -> Mapping[str, float | None]:
    if data is None:
        return {}
    if not isinstance(data, dict):
        raise UserError(f"Invalid measured={data} in {name}.yaml: run scripts/measure_scenes.py {name}.")
    _check_keys(data, tuple(MEASURES), (), f"{name}.yaml, measured")
    for key, value in data.items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise UserError(f"Invalid {key}={value} in {name}.yaml: run scripts/measure_scenes.py {name}.")
    return {key: None if value is None else float(value) for key, value in data.items()}


def contradictions(manifest: Manifest) -> list[str]:
    """Return a sentence for each feature whose level contradicts its measure, by `BOUNDS`."""
    sentences = []
    for feature, bound in BOUNDS.items():
        level, value = manifest.shows[feature], manifest.measured.get(bound.measure)
        if value is None:
            continue
        agrees = {"absent": value <= bound.absent, "present": value > bound.absent, "dominant": value >= bound.dominant}
        if not agrees[level]:
            sentences.append(
                f"{feature} is called {level}, but {bound.measure} is {value:g} "
                f"(absent: at most {bound.absent:g}; dominant: at least {bound.dominant:g})"
            )
    return sentences


def with_measured(text: str, measured: Mapping[str, float | None]) -> str:
    """Return a manifest's text with new measures, rounded to three significant digits; the rest does not change."""
    rest = re.sub(r"^measured:.*\n(?:[ \t].*\n|\n)*", "", text.rstrip("\n") + "\n", flags=re.MULTILINE)
    lines = (f"  {key}: {_format(measured[key])}\n" for key in MEASURES)
    return rest.rstrip("\n") + "\nmeasured:\n" + "".join(lines)


def _format(value: float | None) -> str:
    # YAML 1.1 reads 1e-05, which has no point, as a string.
    return "null" if value is None else f"{float(f'{value:.3g}'):.10f}".rstrip("0").rstrip(".")
