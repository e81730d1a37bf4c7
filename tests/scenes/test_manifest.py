"""Manifests: every mistake is reported, and the words of the built-in scenes agree with their numbers."""

import pytest
import yaml

from supersampling.errors import UserError
from supersampling.scenes.built_in import BUILT_IN
from supersampling.scenes.manifest import (
    BOUNDS,
    FEATURES,
    LEVELS,
    MEASURES,
    Manifest,
    contradictions,
    load_manifest,
    parse,
    with_measured,
)

GOOD = {"title": "A box", "about": "One box. It turns.", "shows": dict.fromkeys(FEATURES, "present")}
EVEN = dict.fromkeys(MEASURES, 0.5)


def text(**changes: object) -> str:
    return yaml.safe_dump({**GOOD, **changes}, sort_keys=False)


def test_parsed_manifest_equals_its_text():
    manifest = parse(text(measured={**EVEN, "speed_95": 12, "reprojection_objects": None}), "box")
    assert (manifest.title, manifest.about) == ("A box", "One box. It turns.")
    assert manifest.shows == GOOD["shows"]
    assert manifest.measured == {**EVEN, "speed_95": 12.0, "reprojection_objects": None}
    assert parse(text(), "box").measured == {}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("- a\n- b\n", "['a', 'b']"),
        ("title: [", "not YAML"),
        (text(titel="x"), "'titel'"),
        (text(title=""), "title= in"),
        (text(about=7), "about=7"),
        (yaml.safe_dump({k: v for k, v in GOOD.items() if k != "shows"}), "'shows'"),
        (text(shows={**GOOD["shows"], "moire": "lots"}), "moire=lots"),
        (text(shows={**GOOD["shows"], "rain": "absent"}), "'rain'"),
        (text(shows={k: v for k, v in GOOD["shows"].items() if k != "glossy"}), "'glossy'"),
        (text(shows="all"), "shows=all"),
        (text(measured={**EVEN, "speed_95": "fast"}), "speed_95=fast"),
        (text(measured={**EVEN, "speed_95": True}), "speed_95=True"),
        (text(measured={**EVEN, "weight": 1.0}), "'weight'"),
        (text(measured={k: v for k, v in EVEN.items() if k != "thin_pixels"}), "'thin_pixels'"),
        (text(measured=[1, 2]), "measured=[1, 2]"),
    ],
)
def test_invalid_manifest_is_reported_with_file_and_value(content, message):
    with pytest.raises(UserError) as error:
        parse(content, "box")
    assert message in str(error.value)
    assert "box.yaml" in str(error.value)


@pytest.mark.parametrize("name", ["nowhere", "stk/zengarden", "../secret", ""])
def test_scene_without_manifest_is_reported(name):
    with pytest.raises(UserError, match="has no manifest"):
        load_manifest(name)


def test_measures_have_three_digits_and_the_rest_of_the_text_stays():
    head = "title: A box   # a note\nabout: >-\n  One box.\n  It turns.\nshows:\n  moire: absent\n"
    values = {**EVEN, "speed_95": 123.456, "speed_median": 0.0000123456, "thin_pixels": 0.0, "moire_pixels": None}
    for before in (head, head + "measured:\n  speed_95: 1\n\n  thin_pixels: 2\n", with_measured(head, EVEN)):
        after = with_measured(before, values)
        assert after.startswith(head + "measured:\n")
        read = yaml.safe_load(after)["measured"]
        rounded = {"speed_95": 123.0, "speed_median": 1.23e-5, "thin_pixels": 0.0, "moire_pixels": None}
        assert read == {**EVEN, **rounded}
        assert with_measured(after, values) == after


@pytest.mark.parametrize("feature", list(BOUNDS))
def test_contradictions_of_levels_and_measures(feature):
    bound = BOUNDS[feature]
    assert bound.absent < bound.dominant

    def contradicts(level: str, value: float) -> bool:
        present = {name: "present" for name in FEATURES if name != feature}
        plenty = dict.fromkeys(MEASURES, 100.0)
        manifest = Manifest("", "", {**present, feature: level}, {**plenty, bound.measure: value})
        return any(sentence.startswith(feature + " ") for sentence in contradictions(manifest))

    between = (bound.absent + bound.dominant) / 2
    assert [contradicts(level, bound.absent) for level in LEVELS] == [True, True, False]
    assert [contradicts(level, between) for level in LEVELS] == [True, False, True]
    assert [contradicts(level, bound.dominant) for level in LEVELS] == [False, False, True]


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_scenes_do_not_contradict_their_measures(name):
    manifest = load_manifest(name)
    assert manifest.measured, f"run scripts/measure_scenes.py {name}"
    assert contradictions(manifest) == []


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_scenes_move_as_their_motion_vectors_say(name):
    measured = load_manifest(name).measured
    for key in ("reprojection_camera", "reprojection_objects"):
        assert measured[key] is None or measured[key] <= 1.0 / 255.0


@pytest.mark.parametrize("feature", FEATURES)
def test_each_feature_is_dominant_in_some_scene_and_absent_from_another(feature):
    levels = {name: load_manifest(name).shows[feature] for name in BUILT_IN}
    assert "dominant" in levels.values(), levels
    assert "absent" in levels.values(), levels
