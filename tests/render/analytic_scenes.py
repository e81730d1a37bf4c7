"""Small scenes, and a float64 pinhole camera that predicts where everything in them appears.

Nothing here uses the renderer's matrices: a camera is an eye and three axes, an image point is a ray.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Camera, Shot, Window
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Material, Mesh, Object, Scene, Sky, Sun

Points = NDArray[np.float64]
DARK = Sky((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
UNIT_UV = ((0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0))  # of corners counter-clockwise from bottom left


def turn(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Points:
    """Return the world-to-camera rotation: roll @ pitch @ yaw about camera z, x and y."""
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    about_y = np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]])
    about_x = np.array([[1, 0, 0], [0, cp, sp], [0, -sp, cp]])
    about_z = np.array([[cr, sr, 0], [-sr, cr, 0], [0, 0, 1]])
    return about_z @ about_x @ about_y


def camera(eye: Sequence[float] = (0.0, 0.0, 0.0), rotation: Points | None = None, fov: float = 1.0) -> Camera:
    view = np.eye(4)
    view[:3, :3] = turn(0.0) if rotation is None else rotation
    view[:3, 3] = -view[:3, :3] @ np.asarray(eye, np.float64)
    return Camera(view, fov)


def whole(width: int, height: int) -> Window:
    return Window(width, height, 0, 0, width, height)


def still(view: Camera, window: Window, seconds: float = 0.0) -> Shot:
    return Shot(view, view, seconds, seconds, window)


def pixel_points(window: Window, scale: int, jitter: tuple[float, float]) -> Points:
    """Return frame pixel positions ``(h, w, 2)`` (x right, y down) of a low-resolution render's samples."""
    y, x = np.mgrid[0 : window.height // scale, 0 : window.width // scale] + 0.5
    return np.stack([window.x + (x + jitter[0]) * scale, window.y + (y + jitter[1]) * scale], axis=-1)


def rays(view: Camera, window: Window, points: Points) -> Points:
    """Return world rays of unit view depth through frame pixel positions."""
    reach = np.tan(view.fov / 2.0)
    x = (2.0 * points[..., 0] / window.frame_width - 1.0) * reach * window.frame_width / window.frame_height
    y = (1.0 - 2.0 * points[..., 1] / window.frame_height) * reach
    return np.stack([x, y, -np.ones_like(x)], axis=-1) @ view.view[:3, :3]  # rows: transpose of the rotation


def eye(view: Camera) -> Points:
    return -view.view[:3, :3].T @ view.view[:3, 3]


def project(view: Camera, window: Window, world: Points) -> Points:
    """Return frame pixel positions of world points."""
    seen = (world - eye(view)) @ view.view[:3, :3].T
    focal = window.frame_height / 2.0 / np.tan(view.fov / 2.0)
    return np.stack(
        [
            window.frame_width / 2.0 - focal * seen[..., 0] / seen[..., 2],
            window.frame_height / 2.0 + focal * seen[..., 1] / seen[..., 2],
        ],
        axis=-1,
    )


def hit(origin: Points, direction: Points, point: Points, normal: Points) -> Points:
    """Return the ray parameter (view depth for `rays`) at which rays meet a plane."""
    return ((point - origin) @ normal) / (direction @ normal)


def quad(corners: Sequence[Sequence[float]], material: int = 0, uv: Sequence[Sequence[float]] = UNIT_UV) -> Mesh:
    """Return a mesh of four corners, counter-clockwise as seen from the front."""
    p = np.asarray(corners, np.float64)
    normal = np.cross(p[1] - p[0], p[2] - p[0])
    normal /= np.linalg.norm(normal)
    return Mesh(
        p.astype(np.float32),
        np.tile(normal, (4, 1)).astype(np.float32),
        np.asarray(uv, np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        material,
    )


def wall(x0: float, x1: float, y0: float, y1: float, z: float, material: int = 0) -> Mesh:
    """Return a wall that faces +z and shows the whole texture once, upright."""
    return quad(((x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)), material)


def floor(half: float, height: float = 0.0, material: int = 0) -> Mesh:
    """Return a floor that faces +y."""
    h = half
    return quad(((-h, height, h), (h, height, h), (h, height, -h), (-h, height, -h)), material)


def glow(level: float, **more: object) -> Material:
    """Return a black, emissive material, whose displayed colour depends on the emission only."""
    black, emission = (0.0, 0.0, 0.0), (level, level, level)
    values: dict[str, object] = {"base_color": black, "emission": emission, "double_sided": True}
    return Material("glow", **(values | more))  # type: ignore[arg-type]


def shift(x: float, y: float, z: float) -> NDArray[np.float32]:
    out = np.eye(4, dtype=np.float32)
    out[:3, 3] = x, y, z
    return out


def scene(
    materials: Sequence[Material],
    meshes: Sequence[Mesh],
    transforms: Sequence[NDArray[np.float32] | Callable[[float], NDArray[np.float32]]] = (),
    sun: Sun | None = None,
    **more: object,
) -> Scene:
    """Return a scene of one object per mesh, static by default, with a black sky and no sun by default."""
    poses = [*transforms, *[np.eye(4, dtype=np.float32)] * (len(meshes) - len(transforms))]
    objects = [Object((i,), pose) for i, pose in enumerate(poses)]
    values: dict[str, object] = {"sky": DARK, "near": 0.5, "far": 50.0}
    return Scene("analytic", materials, meshes, objects, (), sun=sun, **(values | more))  # type: ignore[arg-type]


FRAME = whole(96, 96)
UP = np.array([0.0, 1.0, 0.0])
DOWN = turn(0.0, -np.pi / 2)
MATTE = Material("matte", roughness=1.0, double_sided=True)


def bright(world: Scene, view: Camera, seconds: float = 0.0, shadow_size: int = 1024) -> np.ndarray:
    with Renderer(world, shadow_size) as renderer:
        return renderer.low(still(view, FRAME, seconds), 1, (0.0, 0.0), 0.0, frozenset({"color"}))["color"][..., 1]


def floor_points(view: Camera) -> np.ndarray:
    """Return world points of the floor y = 0 at the pixels, NaN above the horizon."""
    ray = rays(view, FRAME, pixel_points(FRAME, 1, (0.0, 0.0)))
    t = hit(eye(view), ray, np.zeros(3), UP)
    return np.where((t > 0)[..., None], eye(view) + t[..., None] * ray, np.nan)
