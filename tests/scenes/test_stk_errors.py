"""Broken data of a track end in one sentence with the value."""

import struct
from pathlib import Path

import pytest
from stk_files import WALL, WALL_INDICES, spm_bytes, write_track

from supersampling.errors import UserError
from supersampling.scenes.stk import load_track

CURVE = '<object model="a.spm"><curve channel="LocX" fps="25"><p c="1 0"/></curve></object>'


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ('<track model="a.spm" x="1,5"/>', "Invalid number 1,5"),
        ('<track model="a.spm" xyz="0 nan 0"/>', "Invalid number nan"),
        ('<track model="a.spm" scale="1 1e30 1"/>', "Invalid number 1e30"),
        ('<light xyz="0 0 0" energy="bright"/>', "Invalid number bright"),
        ('<sun xyz="0 inf 0" sun-diffuse="1 1 1"/>', "Invalid number inf"),
        ('<lod><group><static-object lod_distance="far"/></group></lod>', "Invalid number far"),
        (CURVE.replace('c="1 0"', 'c="1"'), "Invalid number "),
        (
            CURVE.replace('<curve channel="LocX" fps="25"', '<curve channel="LocX"').replace(
                "<object", '<object fps="0"'
            ),
            "Invalid fps 0.0",
        ),
        (f'<track model="a.spm" scale="{"1e6 " * 3}">' * 8 + "</track>" * 8, "place of a.spm in lane is not finite"),
    ],
)
def test_numbers_of_a_scene(scene: str, words: str, tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", scene)
    (track / "a.spm").write_bytes(spm_bytes([(WALL, WALL_INDICES, ("", ""))]))
    with pytest.raises(UserError, match=words):
        load_track("lane", tmp_path)


@pytest.mark.parametrize(
    ("quads", "words"),
    [
        ('<quad p0="-1:2" p1="0 0 0" p2="0 0 1" p3="1 0 1"/>', "refer to quad -1 of 0"),
        ('<quad p0="0 0 0" p1="0 0 1" p2="1 0 1" p3="7:0"/>', "refer to quad 7 of 0"),
        ('<quad p0="0 0 0" p1="0 0 0" p2="0 0 0" p3="0 0 0"/>' * 3, "is 0 m long"),
        ('<quad p0="0 0 0" p1="0 0 0" p2="0 0 0" p3="0 0 0"/>', "refer to quad 9 of 1|only 1 quads"),
    ],
)
def test_drivelines(quads: str, words: str, tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", "", quads=f"<quads>{quads}</quads>")
    if "only" not in words:
        (track / "graph.xml").unlink()
    with pytest.raises(UserError, match=words):
        load_track("lane", tmp_path)


@pytest.mark.parametrize("face", ['indices="0 1 9"', 'indices="0 1 2" adjacents="4"', 'indices=""'])
def test_navigation_meshes(face: str, tmp_path: Path) -> None:
    track = write_track(tmp_path, "hall", "", navmesh=f"<navmesh>{'<vertex/>' * 3}<face {face}/></navmesh>")
    (track / "quads.xml").unlink()
    with pytest.raises(UserError, match="vertex 9 of 3|face 4 of 1|without vertices"):
        load_track("hall", tmp_path)


@pytest.mark.parametrize("count", [0, 3, 100, 0xFFFFFFFF])
def test_counts_of_a_mesh(count: int, tmp_path: Path) -> None:
    """More vertices than there are bytes take no memory, and fewer than the indices reach are refused."""
    track = write_track(tmp_path, "lane", '<track model="a.spm"/>')
    data = bytearray(spm_bytes([(WALL, WALL_INDICES, ("", ""))]))
    place = data.index(struct.pack("<IIH", 4, 6, 0))
    struct.pack_into("<I", data, place, count)
    (track / "a.spm").write_bytes(data)
    with pytest.raises(UserError, match="a.spm is not a valid .spm mesh"):
        load_track("lane", tmp_path)


def test_positions_that_are_not_finite(tmp_path: Path) -> None:
    track = write_track(tmp_path, "lane", '<track model="a.spm"/>')
    wall = [type(v)((float("nan"), 0.0, 0.0)) for v in WALL]
    (track / "a.spm").write_bytes(spm_bytes([(wall, WALL_INDICES, ("", ""))]))
    with pytest.raises(UserError, match="some of its positions are not finite"):
        load_track("lane", tmp_path)
