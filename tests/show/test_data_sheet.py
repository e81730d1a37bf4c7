"""The sheet's layout: whole pixels, nothing over the edge."""

import numpy as np
import pytest

from supersampling.show.drawings import GROUND, wheel
from supersampling.show.sheet import Panel, Section, compose, display_size, fit


@pytest.mark.parametrize(
    ("target", "scale", "width", "shown"),
    [
        ((96, 96), 4, 256, (192, 192)),
        ((256, 192), 4, 256, (256, 192)),
        ((300, 200), 4, 256, (150, 100)),
        ((1920, 1080), 4, 480, (480, 270)),
        ((1920, 1080), 4, 500, (480, 270)),
        ((1920, 1080), 4, 256, (240, 135)),
        ((1920, 1080), 3, 1000, (640, 360)),
    ],
)
def test_display_size(target, scale, width, shown):
    assert display_size(target, scale, width) == shown


def test_low_and_high_resolution_pixels_line_up():
    rng = np.random.default_rng(0)
    low = rng.integers(0, 256, (3, 4, 3), dtype=np.uint8)
    high = np.kron(low, np.ones((4, 4, 1), dtype=np.uint8))
    assert (fit(low, (32, 24)) == fit(high, (32, 24))).all()
    assert (fit(low, (32, 24)) == np.kron(low, np.ones((8, 8, 1), dtype=np.uint8))).all()
    assert (fit(high, (8, 6)) == fit(low, (8, 6))).all()  # reduced by averaging, where it loses nothing


def test_every_panel_is_on_the_sheet_once_and_unchanged():
    colours = [(40 * k + 20, 7, 90 + k) for k in range(5)]
    panels = [Panel(f"buffer {k}", "0 to 1", np.full((10, 20, 3), c, dtype=np.uint8)) for k, c in enumerate(colours)]
    sheet = compose("heading", [Section("a", panels[:3]), Section("none", []), Section("b", panels[3:])], (40, 20), 2)
    assert sheet.shape[0] % 2 == sheet.shape[1] % 2 == 0
    for colour in colours:
        rows, columns = np.nonzero((sheet == colour).all(axis=2))
        assert (np.ptp(rows) + 1, np.ptp(columns) + 1, rows.size) == (20, 40, 800)
    assert (sheet[:, -1] == GROUND).all()
    assert (sheet[-1] == GROUND).all()


def test_long_labels_stay_in_their_column():
    long = Panel("a title that is far too long for its panel", "word " * 40 + "w" * 80, np.zeros((8, 8, 3), np.uint8))
    sheet = compose("a heading that is far too long as well " * 3, [Section("", [long])], (80, 80), 1)
    assert (sheet[:, 94:] == GROUND).all()


def test_legend_shows_the_colour_of_each_direction():
    from supersampling.show import paint

    disc = wheel((200, 160), 3.0)
    radius = 62
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        at = disc[80 + y * (radius - 4), 100 + x * (radius - 4)].astype(int)
        expected = paint.motion(np.array([x, y], dtype=np.float32)[:, None, None], 1.0)[0, 0].astype(int)
        assert np.abs(at - expected).max() < 40
    assert disc[80, 100].min() > 245
    assert (disc[2, 2] == GROUND).all()
