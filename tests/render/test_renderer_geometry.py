"""Where things appear: colour, depth and motion against ray-plane intersections done by hand."""

import numpy as np
import pytest
from analytic_scenes import (
    camera,
    eye,
    glow,
    hit,
    pixel_points,
    project,
    quad,
    rays,
    scene,
    shift,
    still,
    turn,
    wall,
    whole,
)  # fmt: skip

from supersampling.errors import UserError
from supersampling.render import renderer as module
from supersampling.render.camera import Shot, Window
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Material, Scene, Sky, Sun

FRAME = whole(96, 64)
ALL = frozenset({"color", "depth", "motion"})
GEOMETRY = frozenset({"depth", "motion"})


def _low(world: Scene, shot: Shot, jitter: tuple[float, float], buffers: frozenset[str] = ALL, scale: int = 2):
    with Renderer(world, 64) as draw:
        return draw.low(shot, scale, jitter, 0.0, buffers)


def _slanted() -> tuple[Scene, np.ndarray, np.ndarray]:
    """A plane through (0, 0, -6), wider than the view; its point and normal."""
    point, normal = np.array([0.0, 0.0, -6.0]), np.array([0.3, 0.4, 1.0])
    a = np.cross(normal, [0.0, 1.0, 0.0])
    a /= -np.linalg.norm(a)
    b = np.cross(normal, a) / np.linalg.norm(normal)
    corners = [point + 30 * (s * a + t * b) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return scene([glow(0.3)], [quad(corners)]), point, normal


@pytest.mark.parametrize("axis", [0, 1])
def test_an_edge_flips_only_for_jitter_on_its_other_side(axis: int) -> None:
    # The edge lies 0.2 low-resolution pixels right of (below) the centre of low pixel 12.
    window, view = whole(64, 64), camera()
    at = np.full(2, 32.0)
    at[axis] = (12.5 + 0.2) * 2
    edge = 5.0 * rays(view, window, at)[axis]
    if axis == 0:
        meshes = [wall(-9, edge, -9, 9, -5, 0), wall(edge, 9, -9, 9, -5, 1)]
    else:
        meshes = [wall(-9, 9, edge, 9, -5, 0), wall(-9, 9, -9, edge, -5, 1)]
    with Renderer(scene([glow(1.0), glow(0.05)], meshes), 64) as draw:
        for offset, bright in ((0.0, True), (-0.45, True), (0.17, True), (0.23, False), (0.45, False)):
            for other in (-0.4, 0.4):
                jitter = (offset, other) if axis == 0 else (other, offset)
                image = draw.low(still(view, window), 2, jitter, 0.0, frozenset({"color"}))["color"][..., 0]
                line = image[16] if axis == 0 else image[:, 16]
                assert line[11] > 0.6 > line[13]
                assert (line[12] > 0.6) == bright, (offset, other)


@pytest.mark.parametrize("jitter", [(0.0, 0.0), (0.37, -0.21)])
def test_depth_is_linear_and_sky_is_one(jitter: tuple[float, float]) -> None:
    world, point, normal = _slanted()
    view = camera((0.2, -0.1, 0.3), turn(0.1, -0.2, 0.15))
    depth = _low(world, still(view, FRAME), jitter, frozenset({"depth"}))["depth"]
    t = hit(eye(view), rays(view, FRAME, pixel_points(FRAME, 2, jitter)), point, normal)
    seen = (t > 1.0) & (t < 30.0)
    assert seen.mean() > 0.9
    np.testing.assert_allclose(depth[..., 0][seen], (t[seen] - 0.5) / 49.5, atol=2e-6)
    away = still(camera(rotation=turn(np.pi)), FRAME)
    assert (_low(world, away, jitter, frozenset({"depth"}))["depth"] == 1.0).all()


def _motion_error(motion: np.ndarray, truth: np.ndarray, points: np.ndarray, window: Window, scale: int) -> np.ndarray:
    """Difference in low-resolution pixels; ``truth`` are previous frame pixel positions."""
    return np.abs(motion * (window.width, window.height) - (truth - points)).max(axis=-1) / scale


@pytest.mark.parametrize("jitter", [(0.0, 0.0), (-0.31, 0.44)])
def test_motion_of_a_moving_camera(jitter: tuple[float, float]) -> None:
    world, point, normal = _slanted()
    now = camera((0.2, -0.1, 0.3), turn(0.1, -0.2, 0.15))
    before = camera((0.0, 0.1, 0.5), turn(0.16, -0.17, 0.1), fov=1.02)
    out = _low(world, Shot(now, before, 1.0, 0.9, FRAME), jitter, GEOMETRY)
    points = pixel_points(FRAME, 2, jitter)
    ray = rays(now, FRAME, points)
    t = hit(eye(now), ray, point, normal)
    truth = project(before, FRAME, eye(now) + t[..., None] * ray)
    seen = (t > 1.0) & (t < 30.0)
    assert _motion_error(out["motion"], truth, points, FRAME, 2)[seen].max() < 1e-3
    assert np.abs(truth - points)[seen].max() > 2.0


def _mover(seconds: float) -> np.ndarray:
    out = shift(0.6 * seconds, -0.2 * seconds, 0.8 * seconds)
    out[:3, :3] = turn(0.5 * seconds, 0.2 * seconds)
    return out


@pytest.mark.parametrize("jitter", [(0.0, 0.0), (0.25, 0.4)])
def test_motion_of_a_moving_object_alone(jitter: tuple[float, float]) -> None:
    world = scene([glow(0.3), glow(0.1)], [wall(-1, 1, -1, 1, -4), wall(-40, 40, -40, 40, -20, 1)], [_mover])
    view = camera()
    out = _low(world, Shot(view, view, 1.0, 0.8, FRAME), jitter)
    points = pixel_points(FRAME, 2, jitter)
    now, before = _mover(1.0).astype(np.float64), _mover(0.8).astype(np.float64)
    point, normal = now[:3, :3] @ (0, 0, -4) + now[:3, 3], now[:3, :3] @ (0, 0, 1)
    place = hit(np.zeros(3), rays(view, FRAME, points), point, normal)[..., None] * rays(view, FRAME, points)
    local = (place - now[:3, 3]) @ now[:3, :3]
    inside = (np.abs(local[..., :2]) < 0.98).all(axis=-1)
    outside = (np.abs(local[..., :2]) > 1.02).any(axis=-1)
    truth = project(view, FRAME, local @ before[:3, :3].T + before[:3, 3])
    assert inside.sum() > 50
    assert np.abs(truth - points)[inside].min() > 0.1
    assert _motion_error(out["motion"], truth, points, FRAME, 2)[inside].max() < 1e-3
    assert np.abs(out["motion"][outside]).max() < 1e-6


def test_sky_moves_with_the_camera_rotation_alone() -> None:
    world, jitter = scene([glow(0.3)], [wall(-1, 1, -1, 1, 5)]), (0.3, -0.45)
    now, before = camera((1, 2, 0), turn(0.4, 0.3, 0.2)), camera((0, 2, 0), turn(0.36, 0.33, 0.2))
    out = _low(world, Shot(now, before, 1.0, 0.9, FRAME), jitter)
    points = pixel_points(FRAME, 2, jitter)
    truth = project(before, FRAME, eye(before) + rays(now, FRAME, points))
    assert (out["depth"] == 1.0).all()
    assert _motion_error(out["motion"], truth, points, FRAME, 2).max() < 1e-3


def test_the_first_frame_does_not_move() -> None:
    world = scene([glow(0.3)], [wall(-1, 1, -1, 1, -4)], [_mover])
    motion = _low(world, still(camera((0.1, 0, 0), turn(0.1)), FRAME, 0.7), (0.3, 0.2))["motion"]
    assert np.abs(motion).max() < 1e-6


def test_a_window_is_a_crop_of_the_whole_frame() -> None:
    world, _, _ = _slanted()
    stripes = Material("stripes", roughness=0.4)
    posts = [wall(x, x + 0.4, -2, 2, -4 - x, 1) for x in (-3.0, -1.1, 0.3, 1.7)]
    world = scene([glow(0.3), stripes], [*world.meshes, *posts], sky=Sky())
    now, before = camera(rotation=turn(0.1, 0.05)), camera((0.2, 0, 0), turn(0.07, 0.05))
    window, jitter = Window(96, 64, 36, 12, 40, 32), (0.2, -0.3)
    with Renderer(world, 64) as draw:
        full = draw.low(Shot(now, before, 0.0, 0.0, FRAME), 2, jitter, 0.0, ALL)
        part = draw.low(Shot(now, before, 0.0, 0.0, window), 2, jitter, 0.0, ALL)
        target = draw.target(Shot(now, before, 0.0, 0.0, FRAME), 2, 0.0)[12:44, 36:76]
        crop = draw.target(Shot(now, before, 0.0, 0.0, window), 2, 0.0)
    rows, columns = slice(6, 22), slice(18, 38)
    assert ((np.abs(part["color"] - full["color"][rows, columns]) > 2 / 255).mean()) < 0.01
    assert (np.abs(crop - target) > 2 / 255).mean() < 0.01
    near = np.abs(part["depth"] - full["depth"][rows, columns])[..., 0] < 1e-5
    assert near.mean() > 0.99
    moved = part["motion"] * (40, 32) - full["motion"][rows, columns] * (96, 64)
    assert np.abs(moved[near]).max() < 1e-3


@pytest.fixture(scope="module")
def sharp() -> Scene:
    """Edges, sun, shadows and highlights, and no texture: nothing that depends on a mip level."""
    materials = [Material("floor"), Material("post", base_color=(0.8, 0.2, 0.1), roughness=0.3)]
    posts = [wall(x, x + 0.37, -1, 1.5 - 0.4 * x, -4 - x, 1) for x in (-2.0, -0.6, 0.5, 1.3)]
    ground = quad(((-20, -1, 5), (20, -1, 5), (20, -1, -30), (-20, -1, -30)))
    return scene(materials, [ground, *posts], sun=Sun((0.5, 0.8, 0.6)), sky=Sky())


@pytest.mark.parametrize("samples", [2, 3])
def test_the_target_is_the_mean_of_jittered_renders(sharp: Scene, samples: int) -> None:
    window = Window(60, 40, 6, 4, 42, 30)
    shot = still(camera((0, 0.3, 0), turn(0.05, -0.1)), window)
    with Renderer(sharp, 256) as draw:
        target = draw.target(shot, samples, 0.0)
        grid = [(i + 0.5) / samples - 0.5 for i in range(samples)]
        ones = [draw.low(shot, 1, (x, y), 0.0, frozenset({"color"}))["color"] for x in grid for y in grid]
    difference = np.abs(target - np.mean(ones, axis=0))
    assert target.shape == (30, 42, 3)
    assert np.ptp(target) > 0.3
    # A sample that falls on an edge to the last bit may go either way.
    assert (difference > 1 / 255).mean() < 0.005
    assert difference.mean() < 1e-4


def test_tiles_do_not_show_in_the_target(sharp: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    shot = still(camera((0, 0.3, 0), turn(0.05, -0.1)), whole(60, 40))
    with Renderer(sharp, 256) as draw:
        once = draw.target(shot, 2, 0.0)
        monkeypatch.setattr(module, "TILE", 34)  # tiles of 17 target pixels: 4 x 3, with narrow ones at the ends
        tiled = draw.target(shot, 2, 0.0)
    difference = np.abs(once - tiled)
    assert (difference > 1 / 255).mean() < 0.005
    assert difference.mean() < 1e-4


def test_only_the_buffers_asked_for(sharp: Scene) -> None:
    now, before = camera((0, 0.3, 0), turn(0.05, -0.1)), camera((0.1, 0.3, 0), turn(0.02, -0.1))
    shot = Shot(now, before, 0.0, 0.0, FRAME)
    with Renderer(sharp, 256) as draw:
        every = draw.low(shot, 2, (0.1, 0.2), 0.0, ALL)
        for names in ({"color"}, {"depth"}, {"motion"}, {"color", "motion"}, {"depth", "motion"}):
            some = draw.low(shot, 2, (0.1, 0.2), 0.0, frozenset(names))
            assert set(some) == names
            for name in names:
                np.testing.assert_array_equal(some[name], every[name])
        with pytest.raises(UserError, match="96x64"):
            draw.low(shot, 5, (0.0, 0.0), 0.0, ALL)
    assert {k: v.shape for k, v in every.items()} == {"color": (32, 48, 3), "depth": (32, 48, 1), "motion": (32, 48, 2)}
    assert all(v.dtype == np.float32 for v in every.values())


def test_two_renderers_and_two_frames_give_the_same_bytes(sharp: Scene) -> None:
    shot = still(camera((0, 0.3, 0), turn(0.05, -0.1)), FRAME)
    other = still(camera((3, 2, 0), turn(-0.5, -0.4)), FRAME)
    with Renderer(sharp, 256) as draw:
        first, target = draw.low(shot, 2, (0.1, 0.2), -1.0, ALL), draw.target(shot, 2, 0.0)
        draw.target(other, 2, 0.0)
        again = draw.low(shot, 2, (0.1, 0.2), -1.0, ALL)
    with Renderer(sharp, 256) as draw:
        fresh_target, fresh = draw.target(shot, 2, 0.0), draw.low(shot, 2, (0.1, 0.2), -1.0, ALL)
    for name in ALL:
        assert first[name].tobytes() == again[name].tobytes() == fresh[name].tobytes()
    assert target.tobytes() == fresh_target.tobytes()


def _letter() -> np.ndarray:
    """An upright F, dark on light, red in the top-left corner."""
    image = np.full((64, 64, 3), 200, np.uint8)
    image[16:56, 20:28] = image[16:24, 20:48] = image[32:40, 20:40] = 0
    image[:12, :12] = (255, 0, 0)
    return image


@pytest.mark.parametrize("mirrored", [False, True])
def test_textures_are_upright_and_back_faces_are_culled(mirrored: bool) -> None:
    image, placed = _letter(), shift(0, 0, -4)
    if mirrored:
        placed[0, 0] = -1.0
    paint = {"base_color": (1.0, 1.0, 1.0), "albedo": image, "double_sided": False}
    world = scene([glow(1.0, **paint)], [wall(-1, 1, -1, 1, 0)], [placed])
    view = camera(fov=2 * np.arctan(0.25))  # the wall fills the square frame
    behind = camera((0, 0, -8), turn(np.pi), fov=2 * np.arctan(0.25))
    with Renderer(world, 64) as draw:
        front = draw.target(still(view, whole(64, 64)), 1, -8.0)
        back = draw.low(still(behind, whole(64, 64)), 1, (0, 0), 0.0, ALL)
    expected = image[:, ::-1] if mirrored else image
    bright = np.abs(front[..., 1] - front[20, 5, 1]) < 0.1  # green: out in the letter and in the red corner
    assert (bright == (expected[..., 1] == 200)).mean() > 0.99
    corner = front[:10, -10:] if mirrored else front[:10, :10]
    assert corner[..., 0].min() > 0.7
    assert corner[..., 1].max() < 0.05
    assert (back["depth"] == 1.0).all()


def test_both_sides_of_a_double_sided_material_are_lit() -> None:
    sheet = Material("sheet", double_sided=True)
    world = scene([sheet], [wall(-2, 2, -2, 2, -4)], sun=Sun((0.0, 0.0, -1.0)))  # the sun is behind the sheet
    with Renderer(world, 256) as draw:
        shade = draw.target(still(camera(), whole(16, 16)), 1, 0.0)
        lit = draw.target(still(camera((0, 0, -8), turn(np.pi)), whole(16, 16)), 1, 0.0)
    assert shade[8, 8].max() < 0.02
    assert lit[8, 8].min() > 0.5
