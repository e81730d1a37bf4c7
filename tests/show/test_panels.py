"""The panels of a file and their notes."""

import numpy as np
import pytest
from show_files import LOW, write

from supersampling.data.dataset_file import DatasetFile
from supersampling.frames import BUFFERS
from supersampling.show import paint
from supersampling.show.clip import ClipView
from supersampling.show.panels import buffer_panel, jitter_panel, sections
from supersampling.show.scales import Scales, depth_range, exposure

DERIVED = {"lighting", "disocclusion mask", "previous target, warped", "|warped - target|", "|previous - target|"}
PLAIN = Scales(stops=0, nearest=0.0, farthest=1.0, motion=1.0)


@pytest.fixture
def clip_of(tmp_path):
    files = []

    def make(*args, **images):
        files.append(DatasetFile(write(tmp_path, *args, **images)))
        return ClipView(files[-1], 0)

    yield make
    for file in files:
        file.close()


def titles(clip, frame=4):
    return [panel.title for section in sections(clip, frame, (64, 48)) for panel in section.panels]


def test_file_of_all_buffers_gets_every_panel(clip_of):
    shown = titles(clip_of())
    assert sorted(shown) == sorted({*BUFFERS, *DERIVED, "motion's colours"})
    assert shown.index("motion_dual") == shown.index("motion") + 1


def test_colour_and_target_only_get_two_panels(clip_of):
    assert titles(clip_of(("color", "target"))) == ["color", "target"]


def test_frame_without_target_gets_no_high_resolution_panel(clip_of):
    shown = titles(clip_of(), frame=1)
    assert "color" in shown
    assert "lighting" in shown
    assert not [title for title in shown if title.startswith(("high_", "target", "|", "previous"))]


@pytest.mark.parametrize("missing", ["radiance", "material", "emission"])
def test_lighting_needs_all_three(missing, clip_of):
    assert "lighting" not in titles(clip_of({"radiance", "material", "emission"} - {missing}))


def test_lighting_is_radiance_less_emission_over_material(clip_of):
    values = {"radiance": 1.0, "material": 0.25, "emission": 0.5}
    images = {name: np.full((LOW[1], LOW[0], 3), value) for name, value in values.items()}
    [panel] = sections(clip_of(images, **images), 4, (64, 48))[2].panels
    assert panel.note.startswith("all 2,")


def test_label_has_the_range(clip_of):
    roughness = np.full((LOW[1], LOW[0], 1), 0.25)
    roughness[3, 2], roughness[7, 9] = 0.125, 0.75
    panel = buffer_panel(clip_of(("roughness",), roughness=roughness), 0, "roughness", PLAIN)
    assert panel.note.startswith("0.125 to 0.75")
    assert panel.picture[3, 2, 0] == 32
    assert panel.picture[7, 9, 0] == 191


def test_broken_pixels_stand_out_and_are_counted(clip_of):
    motion = np.zeros((LOW[1], LOW[0], 2))
    motion[2, 5, 0], motion[6, 1, 1] = np.nan, np.inf
    panel = buffer_panel(clip_of(("motion",), motion=motion), 0, "motion", PLAIN)
    assert np.argwhere((panel.picture == paint.BROKEN).all(axis=2)).tolist() == [[2, 5], [6, 1]]
    assert panel.note.startswith("2 pixels are not finite")


def test_motion_is_stated_in_low_resolution_pixels(clip_of):
    """0.25 of 16 pixels along x and 0.25 of 12 along y: 5 pixels."""
    clip = clip_of(("motion",), motion=np.full((LOW[1], LOW[0], 2), 0.25))
    scales = Scales.measure(clip, 0)
    assert scales.motion == 5.0
    assert buffer_panel(clip, 0, "motion", scales).note.startswith("up to 5 px")


def test_share_of_the_mask(clip_of):
    motion, dual = np.zeros((LOW[1], LOW[0], 2)), np.zeros((LOW[1], LOW[0], 2))
    dual[:3, :, 0] = 0.5 / LOW[0]
    derived = sections(clip_of(("motion", "motion_dual"), motion=motion, motion_dual=dual), 4, (64, 48))[2]
    assert [panel.note.split(" ")[0] for panel in derived.panels] == ["25.0%"]


def test_jitter_is_drawn_at_its_position(clip_of):
    """x right, y down, in a square that leaves 8 pixels free at the nearer edges."""
    clip = clip_of(("jitter",), jitter=np.array([0.25, -0.375]))
    picture = jitter_panel(clip, 0, (216, 116)).picture.astype(int)
    orange = np.argwhere((picture[..., 0] > 200) & (picture[..., 2] < 80))
    assert orange.mean(axis=0) + 0.5 == pytest.approx((58 - 37.5, 108 + 25), abs=0.6)


@pytest.mark.parametrize(("value", "stops"), [(1.0, 0), (0.25, 2), (16.0, -4), (0.0, 0)])
def test_exposure_brings_bright_parts_to_one(value, stops):
    image = np.full((3, 10, 10), value, dtype=np.float32)
    image[:, 0, :4] = 1000.0 * value  # a few highlights count for nothing
    image[0, 5, 5] = np.inf
    assert exposure(image) == stops


def test_sky_does_not_stretch_the_depth_range():
    depth = np.array([[[0.125, 0.25, 1.0]]], dtype=np.float32)
    assert depth_range(depth) == (0.125, 0.25)
    assert depth_range(np.ones((1, 2, 2), dtype=np.float32)) == (0.0, 1.0)
