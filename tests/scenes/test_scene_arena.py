"""The arena: name plates that follow their figures, a display that fits the frame, feet that stand on the ground."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.scenes.arena.arena import WALKERS
from supersampling.scenes.arena.figures import HEAD, Coat
from supersampling.scenes.arena.gait import biped
from supersampling.scenes.kit.motion import translation
from supersampling.scenes.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("arena")


def test_interface_and_world_do_not_mix(scene):
    for thing in scene.objects:
        for m in thing.meshes:
            material = scene.materials[scene.meshes[m].material]
            assert material.interface == (thing.frame != "world"), material.name
            if material.interface:
                assert min(material.emission) > 0
                assert material.albedo is not None


def test_display_fits_the_frame_and_leaves_the_middle_free(scene):
    covered = np.zeros((1080, 1920), dtype=bool)
    focal = 540.0 / np.tan(1.05 / 2)
    for thing in (o for o in scene.objects if o.frame == "camera"):
        for seconds in (0.0, 3.0, 11.0):
            pose = thing.at(seconds).astype(float)
            points = np.concatenate([scene.meshes[m].positions for m in thing.meshes]) @ pose[:3, :3].T + pose[:3, 3]
            assert (points[:, 2] < -2 * scene.near).all()
            x = 960.0 + focal * points[:, 0] / -points[:, 2]
            y = 540.0 - focal * points[:, 1] / -points[:, 2]
            assert min(x.min(), y.min()) >= 0
            assert x.max() <= 1920
            assert y.max() <= 1080
            covered[int(y.min()) : int(y.max()), int(x.min()) : int(x.max())] = True
    assert 0.08 < covered.mean() < 0.3


def test_every_figure_carries_a_plate(scene):
    labels = [o for o in scene.objects if o.frame == "billboard"]
    world = [o for o in scene.objects if o.moves and o.frame == "world"]
    assert len(labels) >= len(WALKERS)
    for seconds in (0.0, 7.7, 31.0):
        bodies = np.array([o.at(seconds)[:3, 3] for o in world])
        places = np.array([label.at(seconds)[:3, 3] for label in labels])
        away = np.linalg.norm((places[:, None] - bodies[None])[..., [0, 2]], axis=2).min(axis=1)
        assert away.max() < 0.05
        assert places[:, 1].min() > 1.3


def test_walking_foot_stands_still_on_the_ground():
    speed, parts = 1.3, []

    def ride(seconds: float) -> np.ndarray:
        return translation((speed * seconds, 0, 0)).astype(np.float32)

    biped(lambda shapes, motion: parts.append((shapes, motion)), ride, speed, 0.4, Coat(0, 1, 2, 3), 0, 1.0)
    points = [np.concatenate([s.positions for s, _ in shapes]) for shapes, _ in parts]
    lowest, top, ankles = [], [], []
    feet = [k for k, p in enumerate(points) if p[:, 1].min() > -0.11 and p[:, 1].max() < 0.06 and len(p) > 50]
    assert len(feet) == 2
    for seconds in np.arange(0.0, 3.0, 1.0 / 60.0):
        poses = [motion(float(seconds)).astype(float) for _, motion in parts]
        heights = [(p @ m[:3, :3].T + m[:3, 3])[:, 1] for p, m in zip(points, poses)]
        lowest.append(min(h.min() for h in heights))
        top.append(max(h.max() for h in heights))
        ankles.append([poses[k][:3, 3] for k in feet])
    assert min(lowest) > -0.03
    assert max(lowest) < 0.03
    assert min(top) > 0.8 * HEAD
    track = np.array(ankles)
    step = np.diff(track, axis=0)[..., 0] * 60.0
    # At every moment one foot nearly stands: it moves much less than the body does.
    assert np.abs(step).min(axis=1).mean() < 0.3 * speed
