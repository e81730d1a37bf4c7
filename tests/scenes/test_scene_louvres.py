"""The louvres alias at a quarter of 1080p and are resolved at 1080p; nothing shines, glows or is cut out."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.scenes.louvres import parts
from supersampling.scenes.scene import Scene

FOCAL = 135.0 / np.tan(1.05 / 2)  # pixels, of a frame of 270 rows


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("louvres")


def test_all_is_matt_and_nothing_glows_or_is_cut_out(scene):
    for m in scene.materials:
        least = 1.0 if m.surface is None else m.surface[..., 0].min() / 255
        assert m.roughness * least >= 0.5, m.name
        assert m.metallic == 0.0
        assert m.emission == (0.0, 0.0, 0.0)
        assert m.alpha == "opaque"
        assert not m.interface
    assert not scene.points


def _period(scene: Scene, name: str, axis: int, box: tuple[tuple[float, float], ...]) -> float:
    """Return the metres between neighbouring blades of a material within a box (x, y, z), from their corners."""
    index = next(i for i, m in enumerate(scene.materials) if m.name == name)
    corners = np.concatenate([m.positions for m in scene.meshes if m.material == index])
    inside = np.all([(corners[:, k] > lo) & (corners[:, k] < hi) for k, (lo, hi) in enumerate(box)], axis=0)
    places = np.unique(corners[inside, axis].round(4))
    # Twice as many levels as blades where two corners of a blade differ: the shift that maps the set onto itself.
    shifts = np.arange(0.02, 0.2, 0.0005)
    errors = [np.abs(places[:, None] + s - places[None]).min(axis=1)[: len(places) // 2].mean() for s in shifts]
    return float(shifts[np.asarray(errors) < 0.0006][0])


# Fins of the pavilion, the balcony's balusters and the louvres over it, from both walks along the street.
FINS = ("cedar", 0, ((-15.8, -12.2), (0.1, 0.2), (-7.1, -6.9)), (4.4, 9.8))
BALUSTERS = ("anthracite paint", 0, ((-15.0, 15.0), (3.38, 3.4), (-6.1, -6.0)), (4.5, 9.5))
LOUVRES = ("white paint", 1, ((-15.9, -12.1), (4.4, 6.2), (-7.1, -6.9)), (4.6, 9.8))


@pytest.mark.parametrize(("material", "axis", "box", "distances"), [FINS, BALUSTERS, LOUVRES])
def test_periods_alias_low_and_are_resolved_high(scene, material, axis, box, distances):
    period = _period(scene, material, axis, box)
    for distance in distances:
        pixels = FOCAL * period / distance
        assert 1.0 <= pixels <= 3.5
        assert 4 * pixels > 4.0


def test_rows_have_their_pitch():
    fins = parts.fins(3.0, 2.0, 0.05, 0.02, 0.04)
    middles = fins.positions.reshape(60, -1, 3).mean(axis=1)
    np.testing.assert_allclose(np.diff(middles[:, 0]), 0.05)
    assert middles[0, 0] == pytest.approx(-1.475)


def test_corrugated_normals_stand_on_the_sheet():
    sheet = parts.corrugated(1.0, 2.0, 0.1, 0.02)
    row = sheet.positions[: len(sheet.positions) // 2]
    tangent = np.gradient(row, axis=0)[1:-1]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = sheet.normals[: len(row)][1:-1]
    assert np.abs((tangent * normal).sum(axis=1)).max() < 0.12  # six chords per wave
    assert (normal[:, 2] > 0).all()


def test_motion_is_slow(scene):
    moving = [o for o in scene.objects if o.moves]
    assert len(moving) >= 6
    for thing in moving:
        points = np.concatenate([scene.meshes[m].positions for m in thing.meshes]).astype(float)
        places = np.stack([points @ thing.at(t)[:3, :3].T + thing.at(t)[:3, 3] for t in np.linspace(0.0, 10.0, 601)])
        assert np.linalg.norm(np.diff(places, axis=0), axis=2).max() < 0.005  # metres per frame of 1/60 s
