"""Every broken or hostile file ends in one clear sentence, and nothing outside the file's folder is read."""

import json
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from gltf_files import Builder, check_error, data_uri, png, square_file

from supersampling.scenes.gltf import load_gltf


def textured(image: dict) -> Builder:
    file = Builder()
    texture = file.add("textures", {"source": file.add("images", image)})
    file.node(mesh=file.square(file.material(pbrMetallicRoughness={"baseColorTexture": {"index": texture}})))
    return file


def test_what_is_no_gltf_file(tmp_path: Path) -> None:
    check_error(tmp_path / "none.glb", "Missing glTF file")
    for name, content, words in (
        ("picture.gltf", png(np.zeros((2, 2, 3))), "neither JSON text nor a GLB"),
        ("text.gltf", b"once upon a time", "its JSON is invalid"),
        ("cut.gltf", b'{"asset": {"version": "2.0"', "its JSON is invalid"),
        ("number.gltf", b'{"asset": {"version": "2.0"}, "scene": NaN}', "its JSON is invalid"),
        ("list.gltf", b"[1, 2]", "no asset"),
        ("empty.glb", b"", "its JSON is invalid"),
        (
            "shapes.gltf",
            b'{"asset": {"version": "2.0"}, "nodes": [7]}',
            r"Invalid nodes\[0\] of shapes.gltf: 7 is not an object",
        ),
        (
            "words.gltf",
            b'{"asset": {"version": "2.0"}, "nodes": [{"mesh": "chair"}]}',
            r"Invalid nodes\[0\].mesh of words.gltf: \"chair\"",
        ),
        ("deep.gltf", b'{"asset": {"version": "2.0"}, "extras": ' + b"[" * 100000, "its JSON is invalid"),
    ):
        (tmp_path / name).write_bytes(content)
        check_error(tmp_path / name, words)


@pytest.mark.parametrize("kept", [4, 11, 19, 200, -1])
def test_truncated_glb(kept: int, tmp_path: Path) -> None:
    path = square_file().glb(tmp_path / "cut.glb")
    path.write_bytes(path.read_bytes()[:kept])
    check_error(path, "cut short")


def test_chunks_that_reach_beyond_the_container(tmp_path: Path) -> None:
    data = bytearray(square_file().glb(tmp_path / "a.glb").read_bytes())
    struct.pack_into("<I", data, 12, 1 << 31)
    (tmp_path / "a.glb").write_bytes(data)
    check_error(tmp_path / "a.glb", "cut short")


def test_other_versions(tmp_path: Path) -> None:
    (tmp_path / "old.gltf").write_text('{"asset": {"version": "1.0"}, "nodes": {"box": {}}}')
    check_error(tmp_path / "old.gltf", "version 1.0")
    (tmp_path / "old.glb").write_bytes(b"glTF" + struct.pack("<II", 1, 24) + bytes(16))
    check_error(tmp_path / "old.glb", "version 1:")


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu"])
def test_required_extensions_are_named(name: str, tmp_path: Path) -> None:
    file = square_file()
    file.json["extensionsRequired"] = ["KHR_lights_punctual", name]
    check_error(file.glb(tmp_path / "a.glb"), name)


def test_missing_and_short_buffers(tmp_path: Path) -> None:
    path = square_file().gltf(tmp_path / "a.gltf", uri="a.bin")
    (tmp_path / "a.bin").write_bytes((tmp_path / "a.bin").read_bytes()[:-1])
    check_error(path, "cut short")
    (tmp_path / "a.bin").unlink()
    check_error(path, "missing file 'a.bin' as buffer 0")
    (tmp_path / "a.bin").mkdir()
    check_error(path, "missing")
    path.write_text(path.read_text().replace('"a.bin"', '"data:application/octet-stream;base64,@@@"'))
    check_error(path, "data URI of buffer 0")


OUTSIDE = (
    "../secret.bin",
    "sub/../../secret.bin",
    "%2e%2e/secret.bin",
    "..\\secret.bin",
    "{folder}/secret.bin",
    "file://{folder}/secret.bin",
    "https://example.org/secret.bin",
    "C:\\secret.bin",
    "\\\\server\\secret.bin",
    "link.bin",
    "linked/secret.bin",
)


@pytest.mark.parametrize("uri", OUTSIDE)
@pytest.mark.parametrize("kind", ["buffers", "images"])
def test_uris_do_not_leave_the_folder(uri: str, kind: str, tmp_path: Path) -> None:
    """The file is there and would do, if it could be read."""
    inside = tmp_path / "inside"
    (inside / "sub").mkdir(parents=True)
    secret = tmp_path / "secret.bin"
    (inside / "link.bin").symlink_to(secret)
    (inside / "linked").symlink_to(tmp_path)
    given = uri.format(folder=tmp_path)
    if kind == "images":
        secret.write_bytes(png(np.zeros((2, 2, 3))))
        path = textured({"uri": given}).gltf(inside / "a.gltf")
    else:
        path = square_file().gltf(inside / "a.gltf", uri="a.bin")
        secret.write_bytes((inside / "a.bin").read_bytes())
        head = json.loads(path.read_text())
        head["buffers"][0]["uri"] = given
        path.write_text(json.dumps(head))
    check_error(path, "leaves the file's folder")


def test_links_and_dots_within_the_folder_are_fine(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "real.png").write_bytes(png(np.full((2, 2, 3), 9)))
    (tmp_path / "link.png").symlink_to(tmp_path / "maps" / "real.png")
    for uri in ("link.png", "maps/../maps/real.png", "./maps/real%2Epng"):
        (made,) = load_gltf(textured({"uri": uri}).glb(tmp_path / "a.glb")).materials
        assert made.albedo is not None
        assert (made.albedo == 9).all()


def test_missing_and_unreadable_images(tmp_path: Path) -> None:
    check_error(textured({"uri": "gone.png"}).glb(tmp_path / "a.glb"), "missing file 'gone.png' as image 0")
    check_error(textured({}).glb(tmp_path / "a.glb"), "neither a uri nor a buffer view")
    for name, data in (
        ("text", b"not a picture"),
        ("gif", png(np.zeros((2, 2)), "GIF")),
        ("bmp", png(np.zeros((2, 2)), "BMP")),
    ):
        path = textured({"uri": data_uri(data, "image/png")}).glb(tmp_path / f"{name}.glb")
        check_error(path, "neither PNG nor JPEG")
    noise = np.random.default_rng(0).integers(0, 256, (32, 32, 3))
    check_error(textured({"uri": data_uri(png(noise)[:-400])}).glb(tmp_path / "a.glb"), "damaged")


def claimed(width: int, height: int) -> bytes:
    """The beginning of a PNG that would be as large as that, with next to no data."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = b"IDAT" + zlib.compress(bytes(100))
    chunks = b"".join(struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in (header, data))
    return b"\x89PNG\r\n\x1a\n" + chunks


@pytest.mark.parametrize("size", [(16385, 1), (1, 20000), (16000, 16000), (100000, 100000)])
def test_images_that_are_too_large(size: tuple[int, int], tmp_path: Path) -> None:
    check_error(textured({"uri": data_uri(claimed(*size))}).glb(tmp_path / "a.glb"), "too large")


@pytest.mark.parametrize(
    ("kind", "key", "value", "words"),
    [
        ("nodes", "children", "x", r"nodes\[0\].children of a.glb: \"x\" is not a list"),
        ("nodes", "mesh", True, r"nodes\[0\].mesh of a.glb: true is not a whole number"),
        ("nodes", "translation", [0, "1", 0], r"nodes\[0\].translation\[1\] of a.glb: \"1\" is not a number"),
        ("nodes", "scale", [1e13, 1, 1], "Invalid scale .* of node 0 of a.glb"),
        ("meshes", "primitives", {}, r"meshes\[0\].primitives of a.glb: {} is not a list"),
        ("meshes", "primitives", [{"attributes": {"POSITION": "0"}}], r"attributes.POSITION of a.glb: \"0\""),
        ("accessors", "count", 4.0, r"accessors\[0\].count of a.glb: 4.0 is not a whole number"),
        ("accessors", "count", 1 << 30, "Accessor 0 of a.glb has the invalid type VEC3 or count 1073741824"),
        ("bufferViews", "buffer", None, r"refers to buffers\[None\]"),
    ],
)
def test_values_of_another_type_are_named_with_their_place(
    kind: str, key: str, value: object, words: str, tmp_path: Path
) -> None:
    file = square_file()
    file.json[kind][0][key] = value
    check_error(file.glb(tmp_path / "a.glb"), words)


def test_an_accessor_without_data_takes_no_memory_that_its_count_declares(tmp_path: Path) -> None:
    file = square_file()
    file.json["accessors"][0] = {"componentType": 5126, "count": 1 << 25, "type": "VEC3"}
    check_error(file.glb(tmp_path / "a.glb"), "count 33554432")
    file.json["accessors"][0]["count"] = 4
    check_error(file.glb(tmp_path / "b.glb"), "spans .* m: check its nodes' transforms")
