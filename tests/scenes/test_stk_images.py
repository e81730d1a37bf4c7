from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from png_files import png_bytes, write_png_file

from supersampling.errors import UserError
from supersampling.scenes.stk.images import linear, read_image, upright_normals


def bumps(flip: bool) -> np.ndarray:
    """A normal map of a smooth periodic height field, with green up or down."""
    rows, columns = np.mgrid[0:64, 0:64] * (2.0 * np.pi / 64.0)
    height_x = np.cos(columns + np.sin(rows))  # derivative of sin(columns + sin(rows)) along x
    height_up = -np.cos(columns + np.sin(rows)) * np.cos(rows)
    normal = np.stack([-height_x, -height_up, np.ones_like(rows)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    if flip:
        normal[..., 1] *= -1.0
    return np.round((normal + 1.0) * 127.5).astype(np.uint8)


@pytest.mark.parametrize("flip", [False, True])
def test_normal_maps_come_out_with_green_up(flip: bool) -> None:
    np.testing.assert_allclose(upright_normals(bumps(flip)).astype(int), bumps(False).astype(int), atol=1)


def test_sides_become_powers_of_two_and_top_stays_top(tmp_path: Path) -> None:
    pixels = np.zeros((50, 300, 3), np.uint8)
    pixels[:25] = 255
    Image.fromarray(pixels).save(tmp_path / "a.png")
    image = read_image(tmp_path / "a.png", alpha=False, largest=128)
    assert image.shape == (64, 128, 3)
    assert image[0].min() == 255
    assert image[-1].max() == 0


def test_clear_texels_take_the_colour_of_the_rest(tmp_path: Path) -> None:
    pixels = np.zeros((8, 8, 4), np.uint8)
    pixels[:4] = (10, 200, 30, 255)
    Image.fromarray(pixels).save(tmp_path / "leaf.png")
    image = read_image(tmp_path / "leaf.png", alpha=True)
    assert (image[..., :3] == (10, 200, 30)).all()
    assert (image[:4, :, 3] == 255).all()
    assert (image[4:, :, 3] == 0).all()


def test_sixteen_bits_are_rounded_and_grey_is_not_clipped(tmp_path: Path) -> None:
    values = np.arange(0, 65536, 256).reshape(16, 16, 1)
    expected = np.floor(values / 257 + 0.5).repeat(3, axis=-1)
    grey = write_png_file(tmp_path / "grey.png", values, color=0, depth=16)
    np.testing.assert_array_equal(read_image(grey, alpha=False), expected)
    color = write_png_file(tmp_path / "color.png", values.repeat(3, axis=-1), depth=16)
    np.testing.assert_array_equal(read_image(color, alpha=False), expected)


def test_damaged_and_foreign_images_are_errors(tmp_path: Path) -> None:
    data = bytearray(png_bytes(np.zeros((4, 4, 3), int)))
    data[50] ^= 1
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(UserError, match=r"a\.png is truncated or damaged"):
        read_image(tmp_path / "a.png", alpha=False)
    (tmp_path / "a.png").write_bytes(b"text")
    with pytest.raises(UserError, match=r"a\.png is neither PNG nor JPEG"):
        read_image(tmp_path / "a.png", alpha=False)


def test_linear_light_of_known_srgb_values() -> None:
    np.testing.assert_allclose(linear(np.array([0.0, 0.04, 0.5, 1.0])), [0.0, 0.04 / 12.92, 0.2140411, 1.0], rtol=1e-5)
