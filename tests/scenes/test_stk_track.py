import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from stk_files import WALL, WALL_INDICES, Vertex, spm_bytes, write_track

from supersampling.errors import UserError
from supersampling.scenes.scene import Object, Scene
from supersampling.scenes.stk import available_tracks, find_data, load_track
from supersampling.scenes.stk.attribution import attribution

SUN = '<sun xyz="0 100 -100" sun-diffuse="255 0 51" ambient="120 120 120"/>'


def write_mesh(path: Path, texture: str, colour: tuple[int, int, int] | None = None) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    wall = [Vertex(v.position, v.normal, colour, v.uv) for v in WALL]
    path.write_bytes(spm_bytes([(wall, WALL_INDICES, (texture, ""))], colors=colour is not None))


def write_image(path: Path, pixels: np.ndarray) -> None:
    Image.fromarray(pixels.astype(np.uint8)).save(path)


def placed(scene: Scene, item: Object) -> np.ndarray:
    """World positions ``(N, 3)`` of an object's first mesh."""
    matrix = item.at(0.0)
    return scene.meshes[item.meshes[0]].positions @ matrix[:3, :3].T + matrix[:3, 3]


def corners(scene: Scene) -> set[tuple[float, ...]]:
    """Least corner of each object, to tell them apart."""
    return {tuple(float(v) for v in placed(scene, item).min(axis=0).round(3)) for item in scene.objects}


def test_geometry_is_mirrored_and_stays_front_facing(tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", '<track model="wall.spm" x="1" y="0" z="2"/>' + SUN)
    write_mesh(track / "wall.spm", "paint.png")
    scene = load_track("lane", tmp_path)
    (item,) = scene.objects
    mesh = scene.meshes[item.meshes[0]]
    world = placed(scene, item)
    # The game's z = 5 at an offset of 2 is z = -7 here.
    np.testing.assert_allclose(world, [[1, 0, -7], [1, 2, -7], [4, 2, -7], [4, 0, -7]], atol=1e-6)
    np.testing.assert_allclose(mesh.normals, np.tile([0.0, 0.0, 1.0], (4, 1)), atol=1e-6)
    a, b, c = (world[mesh.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a) @ np.array([0.0, 0.0, 1.0]) > 0.0).all()
    # Seen from +z, u runs to the right with x and v down against y: writing on the wall reads rightly.
    np.testing.assert_allclose(mesh.uv, [[0, 1], [0, 0], [1, 0], [1, 1]])
    assert scene.sun is not None
    np.testing.assert_allclose(scene.sun.direction, [0.0, 0.5**0.5, 0.5**0.5], atol=1e-6)
    np.testing.assert_allclose(scene.sun.radiance, [1.0, 0.0, 0.2], atol=1e-6)


def test_libraries_details_and_conditions(tmp_path: Path) -> None:
    group = '<static-object lod_distance="{}" lod_group="g" model="{}"/>'
    track = write_track(
        tmp_path,
        "lane",
        f'<lod><group name="g">{group.format(90, "far.spm")}{group.format(30, "near.spm")}</group></lod>'
        '<track model="missing.spm"><static-object lod_instance="true" lod_group="g" xyz="10 0 0"/></track>'
        '<library name="post" xyz="20 0 0" scale="2 2 2"/><library name="nowhere"/><library name="../../outside"/>'
        '<object type="animation" model="near.spm" xyz="30 0 0" if="isTrackReverse"/>'
        '<object type="animation" model="near.spm" xyz="40 0 0" if="isTrackNotReverse"/>'
        '<object type="animation" model="near.spm" xyz="50 0 0" ifnot="isTrackNotReverse"/>'
        '<object type="animation" model="near.spm" xyz="60 0 0" interaction="physics-only"/>'
        '<object type="animation" model="near.spm" xyz="70 0 0" displacing="true"/>'
        '<object type="billboard" model="near.spm" xyz="80 0 0"/>',
    )
    write_mesh(track / "near.spm", "", (255, 0, 0))
    write_mesh(track / "far.spm", "", (0, 255, 0))
    write_mesh(tmp_path / "library" / "post" / "post.spm", "")
    (tmp_path / "library" / "post" / "node.xml").write_text(
        '<scene><object model="post.spm" xyz="1 0 0"/><library name="post" xyz="9 9 9"/></scene>'
    )
    (tmp_path.parent / "outside").mkdir(exist_ok=True)
    scene = load_track("lane", tmp_path)
    found = corners(scene)
    assert (10.0, 0.0, -5.0) in found
    assert (40.0, 0.0, -5.0) in found
    assert (22.0, 0.0, -10.0) in found
    assert not {x for x, _, _ in found} & {30.0, 50.0, 60.0, 70.0, 80.0}
    detailed = next(o for o in scene.objects if placed(scene, o)[0, 0] == 10.0)
    np.testing.assert_allclose(scene.meshes[detailed.meshes[0]].colors, np.tile([1.0, 0.0, 0.0], (4, 1)))


def test_models_are_shared_and_animated_objects_move(tmp_path: Path) -> None:
    curve = '<curve channel="LocY" interpolation="linear" extend="cyclic"><p c="1 0"/><p c="26 10"/></curve>'
    track = write_track(tmp_path, "lane", f'<object model="a.spm"/><object model="a.spm" xyz="0 7 0">{curve}</object>')
    write_mesh(track / "a.spm", "", (128, 128, 128))
    scene = load_track("lane", tmp_path)
    still, moving = scene.objects
    assert still.meshes == moving.meshes
    assert not still.moves
    assert moving.moves
    assert moving.at(0.25)[1, 3] == pytest.approx(2.5)
    colors = scene.meshes[still.meshes[0]].colors
    assert colors is not None
    np.testing.assert_allclose(colors, 0.2158605, rtol=1e-4)  # sRGB 128 in linear light


def test_materials_follow_materials_xml(tmp_path: Path) -> None:
    names = ("plain", "leaf", "water", "halo", "grass", "lit", "shiny")
    materials = (
        '<materials><material name="leaf.png" shader="alphatest" backface-culling="N"/>'
        '<material name="Water.png" shader="alphablend"/><material name="halo.png" shader="additive"/>'
        '<material name="grass.png" shader="grass"/><material name="lit.png" shader="unlit"/>'
        '<material name="shiny.png" gloss-map="gloss.png"/></materials>'
    )
    track = write_track(
        tmp_path, "lane", "".join(f'<object model="{name}.spm"/>' for name in names), materials=materials
    )
    for name in names:
        write_mesh(track / f"{name}.spm", f"{name}.png", (0, 0, 255))
        pixels = np.full((8, 16, 4), 200)
        pixels[:, 8:, 3] = 0
        if name == "water":
            pixels[..., 3] = 80
        write_image(tmp_path / "textures" / f"{name}.png", pixels)
    gloss = np.zeros((4, 4, 3))
    gloss[..., 0], gloss[..., 1], gloss[..., 2] = 255, 128, 255
    write_image(tmp_path / "textures" / "gloss.png", gloss)
    scene = load_track("lane", tmp_path)
    made = {m.name.removesuffix(".png"): m for m in scene.materials}
    assert "halo" not in made
    assert made["plain"].alpha == "opaque"
    assert made["plain"].albedo is not None
    assert made["plain"].albedo.shape == (8, 16, 3)
    assert (made["leaf"].alpha, made["leaf"].alpha_cutoff, made["leaf"].double_sided) == ("test", 0.5, True)
    assert made["water"].alpha_cutoff == pytest.approx(80 / 255 / 2, abs=1e-3)  # thin water is there
    assert made["lit"].emission[0] > 0.0
    # Gloss 1 is Blinn-Phong's exponent 2048: alpha^2 = 2 / 2050, roughness 0.1767.
    assert made["shiny"].surface is not None
    np.testing.assert_array_equal(made["shiny"].surface[0, 0], [45, 128, 255])
    assert made["shiny"].emission[0] > 0.0
    tint = {made_name: scene.meshes[k].colors for k, made_name in enumerate(n for n in names if n != "halo")}
    assert tint["grass"] is None
    assert tint["plain"] is not None


def test_routes_run_along_the_mirrored_driveline_without_touching(tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", "")
    assert track.is_dir()
    routes = load_track("lane", tmp_path).routes
    assert len(routes) >= 8
    ends = 0.0
    for route in routes:
        z = route.points[:, 2]
        # Along -z here, one after the other with a gap, inside the 8 m wide road and over its 1 m height.
        assert (np.diff(z) < 0.0).all()
        assert z[0] < ends or ends == 0.0
        assert (np.abs(route.points[:, 0]) <= 2.0).all()
        assert ((route.points[:, 1] >= 2.2) & (route.points[:, 1] <= 3.5)).all()
        ends = float(z[-1]) - 1.0
    assert routes[-1].points[-1, 2] >= -200.0


def test_an_arena_walks_over_its_navigation_mesh(tmp_path: Path) -> None:
    track = write_track(tmp_path, "hall", "")
    for file in ("quads.xml", "graph.xml"):
        (track / file).unlink()
    side = 9
    points = [f'<vertex x="{20 * (k % side)}" y="3" z="{20 * (k // side)}"/>' for k in range(side * side)]
    faces = []
    cells = side - 1
    for row in range(cells):
        for column in range(cells):
            first = row * side + column
            around = [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
            near = " ".join(str(r * cells + c) for r, c in around if 0 <= r < cells and 0 <= c < cells)
            indices = f"{first} {first + 1} {first + side + 1} {first + side}"
            faces.append(f'<face indices="{indices}" adjacents="{near}"/>')
    (track / "navmesh.xml").write_text(f"<navmesh><vertices>{''.join(points)}</vertices>{''.join(faces)}</navmesh>")
    routes = load_track("hall", tmp_path).routes
    assert len(routes) >= 8
    for route in routes:
        assert ((route.points[:, 0] >= 0.0) & (route.points[:, 0] <= 160.0)).all()
        assert ((route.points[:, 2] <= 0.0) & (route.points[:, 2] >= -160.0)).all()
        assert (route.points[:, 1] > 4.0).all()
        assert np.linalg.norm(np.diff(route.points, axis=0), axis=1).max() < 1.5


def test_an_unknown_track_is_named_with_those_that_come_close(tmp_path: Path) -> None:
    write_track(tmp_path, "zengarden", "")
    write_track(tmp_path, "scotland", "")
    assert available_tracks(tmp_path) == ["scotland", "zengarden"]
    with pytest.raises(UserError, match="Unknown SuperTuxKart track zengardn: did you mean zengarden"):
        load_track("zengardn", tmp_path)
    with pytest.raises(UserError, match="Unknown SuperTuxKart track qqq: use one of scotland, zengarden"):
        load_track("qqq", tmp_path)


@pytest.mark.parametrize("name", ["../zengarden", "..", "inner/tracks/zengarden", "/etc", ""])
def test_a_name_never_leads_out_of_the_data(tmp_path: Path, name: str) -> None:
    write_track(tmp_path / "tracks" / "inner", "zengarden", "")
    write_track(tmp_path, "zengarden", "")
    with pytest.raises(UserError, match="Unknown SuperTuxKart track"):
        load_track(name, tmp_path)


def test_a_model_outside_the_data_is_not_read(tmp_path: Path) -> None:
    root = tmp_path / "data"
    write_track(root, "lane", f'<object model="../../../evil.spm"/><object model="{tmp_path}/evil.spm"/>')
    write_mesh(tmp_path / "evil.spm", "")
    assert not load_track("lane", root).objects


def test_missing_data_say_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUPERTUXKART_DATADIR", str(tmp_path))
    assert find_data() is None
    with pytest.raises(UserError, match=r"apt-get install supertuxkart-data \(628 MB\)"):
        load_track("zengarden")
    with pytest.raises(UserError, match="has no tracks folder"):
        available_tracks(tmp_path)
    write_track(tmp_path, "lane", "")
    assert find_data() == tmp_path
    assert load_track("lane").name == "stk/lane"


@pytest.mark.parametrize("name", ["no_such_track", "../../etc", "lane"])
def test_missing_track_and_missing_data_differ(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same name without the game's data, and with data that hold no such track."""
    monkeypatch.delenv("SUPERTUXKART_DATADIR", raising=False)
    monkeypatch.setattr("supersampling.scenes.stk.data._DEBIAN", tmp_path)
    with pytest.raises(UserError, match=r"^SuperTuxKart's data are not installed: apt-get install supertuxkart-data"):
        load_track(name)
    write_track(tmp_path, "square", "")
    with pytest.raises(UserError, match=f"^Unknown SuperTuxKart track {re.escape(name)}: use one of square"):
        load_track(name)


def test_broken_xml_is_named(tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", "")
    (track / "scene.xml").write_text("<scene>")
    with pytest.raises(UserError, match=r"lane/scene\.xml is not valid XML"):
        load_track("lane", tmp_path)


def test_attribution_counts_files_by_the_last_stanza_that_matches(tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", "")
    notice = tmp_path / "copyright"
    notice.write_text(
        "Format: x\n\nFiles: *\nCopyright: 1999 Everybody\nLicense: GPL-3+\n\n"
        "Files: data/tracks/lane/*.png\n data/textures/a.jpg\n"
        "Copyright: 2001 B. Painter\n 2002 C. Sculptor\nLicense: CC-BY-SA-4.0\n"
        "\nFiles: data/tracks/lane/b.png\nCopyright: nobody\nLicense: CC0\n"
    )
    files = [track / "a.png", track / "b.png", track / "c.spm", tmp_path / "textures" / "a.jpg"]
    text = attribution(track, tmp_path, files, notice)
    assert '"Test Lane" by A. Designer' in text
    assert "CC-BY-SA-4.0: 2 files (2001 B. Painter; 2002 C. Sculptor)" in text
    assert "CC0: 1 files (nobody)" in text
    assert "GPL-3+: 1 files" in text
    assert "See the licence files" in attribution(track, tmp_path, files, tmp_path / "absent")
