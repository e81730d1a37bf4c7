"""Seconds per frame of everything that the renderer produces, by scene.

python scripts/timing/render.py [SCENE ...]      default: the built-in scenes and the installed tracks
"""

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

from supersampling.render.camera import Shot, Window
from supersampling.render.paths import camera_path, split_routes
from supersampling.render.renderer import Renderer
from supersampling.scenes.load import installed_scenes, load_scene

FRAMES = 6
USUAL = frozenset({"color", "depth", "motion"})


def median_seconds(work: Callable[[int], object]) -> float:
    """Return the median over frames without the first, which may build caches."""
    times = []
    for k in range(1, FRAMES + 1):
        start = time.perf_counter()
        work(k)
        times.append(time.perf_counter() - start)
    return statistics.median(times[1:])


def measure(name: str) -> None:
    start = time.perf_counter()
    scene = load_scene(name)
    loaded = time.perf_counter() - start
    path = camera_path(split_routes(scene, "train")[0], np.random.default_rng(0), FRAMES + 1)

    def shot(k: int, window: Window) -> Shot:
        return Shot(path.cameras[k], path.cameras[k - 1], path.seconds[k], path.seconds[k - 1], window)

    with Renderer(scene) as renderer:
        image, crop = Window(1920, 1080, 0, 0, 1920, 1080), Window(1920, 1080, 832, 412, 256, 256)
        products = {
            "64x64 input of a window": lambda k: renderer.low(shot(k, crop), 4, (0.1, -0.2), -2.0, USUAL),
            "64x64 motion only": lambda k: renderer.low(shot(k, crop), 4, (0.1, -0.2), -2.0, frozenset({"motion"})),
            "256x256 target, 16 samples": lambda k: renderer.target(shot(k, crop), 4, 0.0),
            "256x256 target, 64 samples": lambda k: renderer.target(shot(k, crop), 8, 0.0),
            "480x270 input": lambda k: renderer.low(shot(k, image), 4, (0.1, -0.2), -2.0, USUAL),
            "1920x1080 target, 16 samples": lambda k: renderer.target(shot(k, image), 4, 0.0),
        }
        triangles = sum(len(scene.meshes[m].triangles) for o in scene.objects for m in o.meshes)
        print(f"{name}: {triangles} triangles, loaded in {loaded:.1f} s, {renderer.gl_renderer}")
        for product, work in products.items():
            print(f"  {product:30s} {median_seconds(work):7.3f} s")


if __name__ == "__main__":
    for scene_name in sys.argv[1:] or installed_scenes():
        measure(scene_name)
