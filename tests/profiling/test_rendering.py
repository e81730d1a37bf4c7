"""Rendering times: what is rendered for a method, in which order, and the tables that the command logs."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import pytest
from omegaconf import OmegaConf

from supersampling.commands.rendering import rendered_scenes
from supersampling.errors import UserError
from supersampling.profiling import rendering
from supersampling.profiling.rendering import full_frame, rendering_table, requests_of
from supersampling.runs.subjects import Subject, subjects_by_name

SIZE = (64, 32)
SECONDS = {"color": 5.0, "depth": 0.25, "motion": 0.5, "target": 100.0, "high_material": 7.0, "high_emission": 3.0}


@pytest.fixture
def methods(entry):
    """Return a function that composes methods by name at 4x4."""

    def compose(*names: str) -> list[Subject]:
        entry("benchmark")
        return subjects_by_name(names, [4])

    return compose


class FakeRenderer:
    """A renderer whose buffers each take a known time, on a clock that nothing else moves."""

    gl_renderer = "fake"

    def __init__(self, scene) -> None:
        self.scene, self.now, self.calls = scene, 0.0, []

    def __enter__(self):
        return self

    def __exit__(self, *error: object) -> None: ...

    def low(self, shot, scale, jitter, bias, buffers):
        self.calls.append(("low", shot.seconds, scale, bias, buffers))
        self.now += sum(SECONDS.get(name, 1.0) for name in buffers) * 16 / scale**2

    def high(self, shot, samples, bias, buffers):
        self.calls.append(("high", shot.seconds, samples, bias, buffers))
        self.now += sum(SECONDS.get(name, 1.0) for name in buffers)


def test_buffers_of_each_part(methods):
    nsrr, nsrd, jau = methods("nsrr", "nsrd", "jau")
    parts = requests_of(nsrr, SIZE)
    assert {name: (set(r.low), set(r.high)) for name, r in parts.items()} == {
        "render": ({"color", "depth", "motion"}, set()),
        "render.g_buffers": ({"depth", "motion"}, set()),
    }
    assert set(requests_of(jau, SIZE)) == {"render"}  # reads the colour only, and no buffer without light
    parts = requests_of(nsrd, SIZE)
    assert parts["render.high"].high == {"high_material", "high_emission"}
    assert "radiance" not in parts["render.g_buffers"].low
    assert parts["render"].low == parts["render.g_buffers"].low | {"radiance"}
    assert parts["render"].high == parts["render.high"].high
    assert (full_frame(SIZE).scale, full_frame(SIZE).low, full_frame(SIZE).high) == (1, {"color"}, set())


@pytest.fixture
def fake(monkeypatch):
    """Replace the renderer, the clock and the camera's path, and return the renderer."""
    renderer = FakeRenderer(SimpleNamespace(name="atrium"))
    monkeypatch.setattr(rendering, "Renderer", lambda scene: renderer)
    monkeypatch.setattr(rendering, "time", SimpleNamespace(perf_counter=lambda: renderer.now))
    monkeypatch.setattr(rendering, "_instants", lambda scene, count: ((None, float(k)) for k in range(count)))
    return renderer


def test_times_and_sizes_of_a_table(methods, fake):
    subjects = methods("nsrr", "nsrd")
    table = rendering_table(fake.scene, subjects, [[64, 32]], 4, 1e9)
    ms = table.set_index(["method", "part"]).ms
    assert ms["nsrr", "render"] == pytest.approx(5750.0)
    assert ms["nsrr", "render.g_buffers"] == pytest.approx(750.0)
    assert ms["nsrd", "render.high"] == pytest.approx(10_000.0)
    assert ms["", "render"] == pytest.approx(80_000.0)  # colour at 16 times as many pixels
    assert set(table.frames) == {4}
    assert set(table.scene) == {"atrium"}
    assert table.set_index("method").architecture[""] == ""
    instants = [seconds for seconds, _ in itertools.groupby(call[1] for call in fake.calls)]
    assert instants == sorted(set(instants))  # every request of an instant before the next one
    assert len(instants) == 5
    bias = {call[3] for call in fake.calls if call[0] == "low"}
    assert bias == {-2.0, 0.0}


def test_equal_requests_are_rendered_once_and_time_limits_them(methods, fake):
    nsrr, dlctus = methods("nsrr", "dlctus")
    assert requests_of(nsrr, SIZE)["render"] == requests_of(dlctus, SIZE)["render"]
    table = rendering_table(fake.scene, [nsrr, dlctus], [[64, 32]], 50, 0.001)
    assert set(table.frames) == {3}
    assert len(table) == 5
    assert len(fake.calls) == 4 * 3  # a first frame and three, for three different requests
    odd = replace(nsrr, scale=5)
    assert set(rendering_table(fake.scene, [odd], [[64, 32]], 1, 1.0).method) == {""}


@pytest.mark.parametrize(
    ("settings", "scenes"),
    [
        ({"rendering": False, "scene": "nowhere"}, []),
        ({"rendering": True, "scene": "atrium"}, ["atrium"]),
        ({"rendering": True, "scene": ["atrium", "gltf"], "path": "some/room.glb"}, ["atrium", "gltf/room"]),
    ],
)
def test_scenes_by_name(settings, scenes):
    assert rendered_scenes(OmegaConf.create({"path": None, **settings})) == scenes


@pytest.mark.parametrize(
    ("scene", "message"),
    [("nowhere", "Unknown scene nowhere"), ([], "Empty scene="), ("gltf", "Missing path for scene=gltf")],
)
def test_mistakes_about_scenes(scene, message):
    with pytest.raises(UserError, match=message):
        rendered_scenes(OmegaConf.create({"rendering": True, "scene": scene, "path": None}))
