"""Images of glTF files of every type, against the integers that were encoded."""

import struct
from pathlib import Path

import numpy as np
import pytest
from gltf_files import Builder, check_error, data_uri
from png_files import CHANNELS, png_bytes

from supersampling.data.readers.png import DEPTHS
from supersampling.scenes.gltf import images
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.images import Images

PALETTE = np.random.default_rng(1).integers(0, 256, (256, 3))


def decode(data: bytes, folder: Path) -> np.ndarray:
    """Return the texture ``(H, W, 4)`` of a file."""
    return Images(Document(textured(data).glb(folder / "a.glb"))).rgba(0)


def textured(data: bytes) -> Builder:
    file = Builder()
    texture = file.add("textures", {"source": file.add("images", {"uri": data_uri(data)})})
    file.node(mesh=file.square(file.material(pbrMetallicRoughness={"baseColorTexture": {"index": texture}})))
    return file


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("color", "depth"), [(c, d) for c in DEPTHS for d in DEPTHS[c]])
def test_every_type_becomes_the_nearest_eight_bits(tmp_path, color, depth, interlaced):
    stored = np.random.default_rng(0).integers(0, 1 << depth, (9, 13, CHANNELS[color]))
    chunks = []
    near = np.floor(stored / ((1 << depth) - 1) * 255.0 + 0.5)
    opaque = np.full_like(near[..., :1], 255.0)
    if color == 3:
        chunks = [(b"PLTE", PALETTE[: 1 << depth].astype(np.uint8).tobytes()), (b"tRNS", b"\7")]
        alpha = np.where(stored == 0, 7, 255)
        expected = np.concatenate([PALETTE[stored[..., 0]], alpha], axis=-1)
    elif color in (4, 6):
        expected = near[..., [0, 0, 0, 1]] if color == 4 else near
    else:
        key = stored[0, 0]
        chunks = [(b"tRNS", struct.pack(f">{len(key)}H", *key))]
        alpha = np.where((stored == key).all(axis=-1, keepdims=True), 0.0, opaque)
        expected = np.concatenate([near.repeat(3 // len(key), axis=-1), alpha], axis=-1)
    data = png_bytes(stored, color=color, depth=depth, interlaced=interlaced, filters=range(5), chunks=chunks)
    np.testing.assert_array_equal(decode(data, tmp_path), expected)


@pytest.mark.parametrize("color", [3, 6])
def test_halving_keeps_palettes_and_colours_of_clear_texels(tmp_path, color, monkeypatch):
    monkeypatch.setattr(images, "USED_SIDE", 8)
    colors = np.repeat(np.repeat(PALETTE[:64].reshape(8, 8, 3), 2, axis=0), 2, axis=1)
    numbers = np.repeat(np.repeat(np.arange(64).reshape(8, 8, 1), 2, axis=0), 2, axis=1)
    if color == 3:
        chunks = [(b"PLTE", PALETTE.astype(np.uint8).tobytes())]
        data = png_bytes(numbers, color=3, chunks=chunks)
    else:
        data = png_bytes(np.dstack([colors, 0 * numbers]), color=6)
    np.testing.assert_array_equal(decode(data, tmp_path)[..., :3], PALETTE[:64].reshape(8, 8, 3))


def test_damaged_pixels_are_an_error(tmp_path):
    """Pillow does not compare the checksum of pixels."""
    data = bytearray(png_bytes(np.zeros((4, 4, 3), int)))
    data[-18] ^= 1
    check_error(textured(bytes(data)).glb(tmp_path / "a.glb"), "The image 0 of a.glb is truncated or damaged")
