"""Types of a scene: meshes, materials, moving objects, lights, sky and the routes a camera may take.

World space is right-handed, y up, metres. A scene is plain data, built once; the renderer only reads it.
Textures are ``(H, W, C)`` uint8 arrays whose row 0 is the row at v = 0 (the top row of the image); u points right and v
down, repeating.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
Texture = NDArray[np.uint8]
Vector = NDArray[np.float64]
Transform = Callable[[float], Array]  # seconds -> (4, 4) object-to-world matrix, column vectors


@dataclass(frozen=True)
class Sampling:
    """Filters of maps, by OpenGL's numbers; ``repeat`` tells for u and v whether maps repeat or extend their edges."""

    minify: int = 9987  # LINEAR_MIPMAP_LINEAR
    magnify: int = 9729  # LINEAR
    repeat: tuple[bool, bool] = (True, True)


@dataclass(frozen=True, eq=False)
class Material:
    """Metallic-roughness material; textures multiply the factors.

    ``albedo`` is sRGB RGBA (or RGB), ``normal`` a tangent-space map (OpenGL convention, y up along +bitangent),
    ``surface`` linear RGB with R = roughness, G = metallic, B = emission mask (white where absent).
    ``emission`` is linear radiance, multiplied by ``glow`` (sRGB RGB) if present, else by the albedo texture and the
    blue channel of the surface map; ``base_color`` does not change it, and the colors of a mesh multiply it if
    ``colored_emission``.
    ``alpha``: ``opaque``; ``test`` discards below ``alpha_cutoff``; ``blend`` is drawn as a test at 0.5.
    ``interface`` marks an element of the user interface (QRISP, annex A.2): only its emission is drawn, over the
    surface behind it, which keeps its depth, motion and object id; it is hidden by surfaces in front of it, takes no
    light and casts no shadow.
    """

    name: str
    albedo: Texture | None = None
    normal: Texture | None = None
    surface: Texture | None = None
    glow: Texture | None = None
    base_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    roughness: float = 0.8
    metallic: float = 0.0
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    alpha: Literal["opaque", "test", "blend"] = "opaque"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    interface: bool = False
    colored_emission: bool = False
    sampling: Sampling = Sampling()


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one material.

    ``positions (N, 3)``, unit ``normals (N, 3)``, ``uv (N, 2)``, ``triangles (M, 3)`` uint32, front faces
    counter-clockwise. ``colors (N, 3)`` or ``(N, 4)`` are linear factors on the albedo, and on its alpha where that is
    tested; white when absent. ``tangents (N, 4)`` are the direction in which the normal map's x points and the sign of
    the bitangent; without them the renderer derives them from the uv.
    """

    positions: Array
    normals: Array
    uv: Array
    triangles: NDArray[np.uint32]
    material: int
    colors: Array | None = None
    tangents: Array | None = None


@dataclass(frozen=True, eq=False)
class Object:
    """Meshes that move together; ``transform`` is a constant matrix, or a function of time for a moving object.

    ``frame`` is the frame of the transform: the ``world``; the ``camera`` (x right, y up, looking down -z: a head-up
    display); or a ``billboard``, whose place is in the world and whose axes are the camera's (a name above a head).
    """

    meshes: tuple[int, ...]
    transform: Array | Transform
    frame: Literal["world", "camera", "billboard"] = "world"

    @property
    def moves(self) -> bool:
        return callable(self.transform) or self.frame != "world"

    def at(self, seconds: float) -> Array:
        return self.transform(seconds) if callable(self.transform) else self.transform


@dataclass(frozen=True)
class Sun:
    """Directional light; ``direction`` points from the surface to the sun, ``radiance`` times pi is its irradiance."""

    direction: tuple[float, float, float] = (0.4, 0.8, 0.3)
    radiance: tuple[float, float, float] = (3.0, 2.8, 2.5)


@dataclass(frozen=True)
class PointLight:
    """Inverse-square light that fades to zero at ``radius`` metres; a ``shadowed`` light has a cube shadow map.

    ``intensity`` is radiant intensity / pi. A spot shines along ``direction``: fully within the half angle ``cone[0]``,
    not at all outside of ``cone[1]`` (radians, as in glTF's KHR_lights_punctual); without a cone it shines everywhere.
    """

    position: tuple[float, float, float]
    intensity: tuple[float, float, float]
    radius: float = 10.0
    shadowed: bool = True
    direction: tuple[float, float, float] = (0.0, -1.0, 0.0)
    cone: tuple[float, float] | None = None


@dataclass(frozen=True)
class Sky:
    """Linear radiance of the zenith, the horizon and below it; also the ambient light (hemisphere irradiance)."""

    zenith: tuple[float, float, float] = (0.25, 0.45, 0.9)
    horizon: tuple[float, float, float] = (0.8, 0.85, 0.9)
    ground: tuple[float, float, float] = (0.25, 0.22, 0.2)
    ambient: float = 1.0


@dataclass(frozen=True, eq=False)
class Route:
    """Line that a camera may walk along: eye positions ``points (N, 3)``; it looks along the line, or at ``focus``.

    ``recorded`` replaces both by the scene's own camera: a function from seconds to the camera-to-world matrix
    ``(4, 4)`` (x right, y up, looking down -z), constant for a camera that stands. ``fov`` is vertical, radians.
    """

    name: str
    points: Array
    focus: Array | None = None
    recorded: Transform | None = None
    fov: float = 1.05


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that the renderer needs; train, val and test split ``routes`` so that their paths are disjoint."""

    name: str
    materials: Sequence[Material]
    meshes: Sequence[Mesh]
    objects: Sequence[Object]
    routes: Sequence[Route]
    sun: Sun | None = field(default_factory=Sun)
    points: Sequence[PointLight] = ()
    sky: Sky = field(default_factory=Sky)
    exposure: float = 1.0
    near: float = 0.1
    far: float = 200.0
    attribution: str = ""


def look_at(eye: Vector, forward: Vector) -> NDArray[np.float64]:
    """Return the world-to-camera matrix of a camera at ``eye`` that looks along ``forward`` (not vertical), y up."""
    back = -forward / np.linalg.norm(forward)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    view = np.eye(4)
    view[:3, :3] = np.stack((right, up, back))
    view[:3, 3] = -view[:3, :3] @ eye
    return view
