"""Only shadows change the sundial: moving objects are out of view; visible ones stand still and hide nothing."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.render.camera import Camera, Shot, Window
from supersampling.render.paths import camera_path, split_routes
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Route, Scene, look_at
from supersampling.scenes.sundial.sundial import APOTHEM, CHAMBER, HALF, RELIEF

SPLITS = ("train", "val", "test")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("sundial")


def _view(route: Route, share: float) -> np.ndarray:
    """Return the world-to-camera matrix at a share of the way along a route."""
    if route.recorded is not None:
        return np.linalg.inv(route.recorded(0.0).astype(np.float64))
    eyes, focus = np.asarray(route.points, np.float64), np.asarray(route.focus, np.float64)
    place = share * (len(eyes) - 1)
    i = min(int(place), len(eyes) - 2)
    eye = eyes[i] + (place - i) * (eyes[i + 1] - eyes[i])
    return look_at(eye, focus[i] + (place - i) * (focus[i + 1] - focus[i]) - eye)


def test_moving_objects_are_out_of_view(scene: Scene) -> None:
    slope = np.tan(1.05 / 2)
    for route in scene.routes:
        for share in (0.0, 0.5, 1.0):
            view = _view(route, share)
            for thing in scene.objects:
                same_room = (thing.at(0.0)[0, 3] < -HALF[0]) == (np.linalg.inv(view)[0, 3] < -HALF[0])
                for seconds in (0.0, 4.0, 11.0, 23.0) if thing.moves and same_room else ():
                    pose = thing.at(seconds)
                    points = np.concatenate([scene.meshes[m].positions for m in thing.meshes])
                    seen = (points @ pose[:3, :3].T + pose[:3, 3]) @ view[:3, :3].T + view[:3, 3]
                    depth = np.maximum(-seen[:, 2], 1e-6)
                    inside = (seen[:, 2] < 0) & (np.abs(seen[:, 1]) < slope * depth)
                    inside &= np.abs(seen[:, 0]) < slope * 16 / 9 * depth
                    assert not inside.any(), route.name


def test_rooms_are_convex_except_for_mouldings(scene: Scene) -> None:
    """Below the tops of the walls nothing stands out further than a moulding, so nothing can hide anything."""
    points = np.concatenate([scene.meshes[m].positions for m in scene.objects[0].meshes]).astype(np.float64)
    low = points[(points[:, 1] > RELIEF) & (points[:, 1] < 5.0)]
    in_court = (np.abs(low[:, [0, 2]]) < np.array(HALF) - RELIEF - 1e-3).all(axis=1)
    assert not in_court.any()
    angles = np.arange(8) * np.pi / 4
    outward = np.stack([np.sin(angles), np.cos(angles)], 1)
    reach = ((low[:, [0, 2]] - CHAMBER) @ outward.T).max(axis=1)
    assert not (reach < APOTHEM - RELIEF - 1e-3).any()
    assert ((np.abs(points[:, [0, 2]]) < np.array(HALF) - RELIEF).all(axis=1)).any()  # the floor's lines are in it


@pytest.mark.parametrize("split", SPLITS)
def test_pixels_change_where_motion_vectors_say_static(scene: Scene, split: str) -> None:
    window = Window(160, 96, 0, 0, 160, 96)
    with Renderer(scene) as renderer:
        for route in split_routes(scene, split)[:2]:
            camera = Camera(_view(route, 0.4))
            frames = []
            for seconds in (8.0, 8.25):
                shot = Shot(camera, camera, seconds, seconds - 1 / 60, window)
                frames.append(renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"color", "motion"})))
            assert max(np.abs(f["motion"]).max() for f in frames) < 1e-5
            changed = np.abs(frames[0]["color"] - frames[1]["color"]).max(axis=2) > 0.05
            assert changed.mean() > 0.02, route.name


def test_each_split_has_both_rooms(scene: Scene) -> None:
    for split in SPLITS:
        x = [camera_path(r, np.random.default_rng(0), 2).cameras[0] for r in split_routes(scene, split)]
        rooms = {bool(np.linalg.inv(c.view)[0, 3] < -HALF[0]) for c in x}
        assert rooms == {True, False}


def test_nothing_shines_glows_or_is_cut_out(scene: Scene) -> None:
    for material in scene.materials:
        assert material.surface is not None
        assert material.surface[..., 0].min() > 0.55 * 255
        assert material.surface[..., 1].max() == 0
        assert max(material.emission) == 0
        assert material.alpha == "opaque"
