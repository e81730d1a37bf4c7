"""Mutated SuperTuxKart tracks: each gives a scene of finite numbers or one sentence."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scene_mutations import Random, check_mutations, mutated_bytes, mutated_text
from stk_files import WALL, WALL_INDICES, Vertex, spm_bytes, write_track

from supersampling.scenes.scene import Scene
from supersampling.scenes.stk import load_track

SCENE = (
    '<sun xyz="10 80 20" sun-diffuse="255 240 220" ambient="90 90 90"/><sky-color rgb="100 120 200"/>'
    '<sky-box texture="s.png s.png s.png s.png s.png s.png"/>'
    '<lod><group name="g"><static-object lod_group="g" lod_distance="50" model="wall.spm"/></group></lod>'
    '<track model="wall.spm" x="1" y="0" z="2"/><static-object lod_group="g" lod_instance="true" xyz="3 0 0"/>'
    '<object model="bone.spm" xyz="0 7 0" hpr="0 90 0" scale="1 2 1"><curve channel="LocX" interpolation="bezier" '
    'extend="cyclic"><p c="1 0" h1="0 0" h2="5 1"/><p c="26 3" h1="20 2" h2="30 3"/></curve></object>'
    '<light xyz="0 3 20" color="255 200 150" energy="2" distance="30"/><library name="lamp" xyz="1 1 1"/>'
)
MATERIALS = (
    '<materials><material name="wall.png" shader="alphatest" normal-map="n.png"/>'
    '<material name="bone.png" shader="solid" gloss-map="s.png" backface-culling="N"/></materials>'
)
POINTS = "".join(f'<vertex x="{5 * (k // 2)}" y="0" z="{5 * (k % 2)}"/>' for k in range(24))
LINKS = [" ".join(str(n) for n in (k - 1, k + 1) if 0 <= n < 11) for k in range(11)]
FACES = "".join(
    f'<face indices="{2 * k} {2 * k + 1} {2 * k + 3} {2 * k + 2}" adjacents="{links}"/>'
    for k, links in enumerate(LINKS)
)
WORDS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e30",
    "1e9",
    "x",
    "",
    "1 2 3",
    "-5 0",
    "99:9",
    "-1:2",
    "0 0 0",
    "true",
    "a.spm",
    "<",
    "é",
)


def write(root: Path) -> Path:
    """Write a track with a bit of everything and return its folder."""
    track = write_track(root, "lane", SCENE, materials=MATERIALS)
    (track / "wall.spm").write_bytes(spm_bytes([(WALL, WALL_INDICES, ("wall.png", ""))], tangents=True))
    mixed = [Vertex(v.position, color=None if k % 2 else (200, 100, 50)) for k, v in enumerate(WALL)]
    bones = [(mixed, WALL_INDICES, ("bone.png", "n.png")), (WALL, WALL_INDICES, ("", ""))]
    (track / "bone.spm").write_bytes(spm_bytes(bones, colors=True, normals=False, skinned=True))
    pixels = np.random.default_rng(0).integers(0, 256, (8, 8, 4), dtype=np.uint8)
    for name in ("wall.png", "bone.png", "n.png", "s.png"):
        Image.fromarray(pixels).save(track / name)
    library = root / "library" / "lamp"
    library.mkdir(exist_ok=True)
    (library / "node.xml").write_text('<node><object model="wall.spm" x="2"/><light energy="1"/></node>')
    return track


def mutate(track: Path, random: Random) -> None:
    """Change one file of a track; a third of the tracks are arenas with a navigation mesh."""
    if not random.integers(3):
        (track / "quads.xml").unlink()
        (track / "navmesh.xml").write_text(f"<navmesh><vertices>{POINTS}</vertices>{FACES}</navmesh>")
    files = sorted([*track.iterdir(), track.parents[1] / "library" / "lamp" / "node.xml"])
    path = files[random.integers(len(files))]
    if path.suffix == ".xml" and random.integers(8):
        path.write_text(mutated_text(path.read_text(), random, WORDS))
    else:
        path.write_bytes(mutated_bytes(path.read_bytes(), random))


def check(scene: Scene) -> None:
    """Assert that a scene can be drawn: finite numbers, and indices that exist."""
    for mesh in scene.meshes:
        for values in (mesh.positions, mesh.normals, mesh.uv, mesh.colors):
            assert values is None or np.isfinite(values).all()
        assert mesh.triangles.max() < len(mesh.positions)
        assert mesh.material < len(scene.materials)
    for item in scene.objects:
        assert np.isfinite([item.at(t) for t in (0.0, 0.3, 1.7)]).all()
    for route in scene.routes:
        assert len(route.points) > 1
        assert np.isfinite(route.points).all()
    for light in scene.points:
        assert np.isfinite([*light.position, *light.intensity, light.radius]).all()
    sky = scene.sky
    assert np.isfinite([*sky.zenith, *sky.horizon, *sky.ground, sky.ambient, scene.exposure]).all()
    assert np.isfinite([*scene.sun.direction, *scene.sun.radiance] if scene.sun else [0.0]).all()
    assert 0.0 < scene.near < scene.far


def load(seed: int, root: Path) -> Scene:
    """Write a mutated track and load it."""
    for stale in (root / "tracks" / "lane").glob("*"):
        stale.unlink()
    mutate(write(root), np.random.default_rng(seed))
    return load_track("lane", root)


def test_the_track_itself_is_whole(tmp_path: Path) -> None:
    write(tmp_path)
    scene = load_track("lane", tmp_path)
    check(scene)
    assert (len(scene.objects), len(scene.points)) == (4, 2)


@pytest.mark.slow
def test_mutated_tracks(tmp_path: Path) -> None:
    check_mutations(lambda seed: check(load(seed, tmp_path)), tmp_path)
