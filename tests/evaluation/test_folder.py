"""Folders of frames: where they may be, and every kind of invalid folder."""

import numpy as np
import OpenEXR
import pytest
from image_files import write_png

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.readers.png_images import read_display_png
from supersampling.errors import UserError
from supersampling.evaluation.folder import clip_files
from supersampling.evaluation.playback import DisplayImages, Playback, RadianceImages, TargetImages
from supersampling.evaluation.protocol import Protocol
from supersampling.evaluation.result import evaluate
from supersampling.metrics.prepare import Continuous
from supersampling.metrics.selection import Metrics
from supersampling.metrics.still import PSNR

SIZE = 48


def targets(path, clip):
    store = DatasetFile(path)
    return store.read("target", clip, slice(None)).transpose(0, 2, 3, 1)


def write_clip(folder, images, first=0):
    folder.mkdir(parents=True, exist_ok=True)
    for number, image in enumerate(images, first):
        write_png(folder / f"shot_{number:03d}.png", np.rint(image * 255).astype(np.uint8))
    return folder


@pytest.fixture
def single(make_file, tmp_path):
    return make_file(tmp_path, "test", clips=1, frames=3)


@pytest.fixture
def folder(single, tmp_path):
    return write_clip(tmp_path / "dlss", targets(single, 0))


def psnr(path, suffix, recording, folder):
    model = Playback(4, recording(clip_files(folder, [path], suffix)))
    return evaluate(model, Metrics([PSNR()]), Protocol(Continuous()), [path]).frames["psnr"]


def test_frames_of_single_clip_in_the_folder_itself(single, folder):
    assert (psnr(single, ".png", DisplayImages, folder) == 100.0).all()


@pytest.mark.parametrize("first", [0, 1, 1047])
def test_numbers_may_begin_anywhere(single, tmp_path, first):
    folder = write_clip(tmp_path / "engine", targets(single, 0), first)
    assert (psnr(single, ".png", DisplayImages, folder) == 100.0).all()


@pytest.mark.parametrize("place", ["analytic/{}", "{}"])
def test_several_clips_in_separate_folders(make_file, tmp_path, place):
    path = make_file(tmp_path, "test", clips=2, frames=3)
    for clip in range(2):
        write_clip(tmp_path / "fsr" / place.format(clip), targets(path, clip))
    assert (psnr(path, ".png", DisplayImages, tmp_path / "fsr") == 100.0).all()


def test_black_frames_count(single, tmp_path):
    images = targets(single, 0)
    folder = write_clip(tmp_path / "black", np.zeros_like(images))
    expected = [-10 * np.log10(np.square(image.astype(np.float64)).mean()) for image in images]
    assert psnr(single, ".png", DisplayImages, folder).tolist() == pytest.approx(expected, abs=1e-4)


def test_sixteen_bits_are_read_as_sixteen(single, tmp_path):
    rng = np.random.default_rng(0)
    values = rng.integers(0, 65536, (SIZE, SIZE, 3)).astype(np.uint16)
    write_png(tmp_path / "deep.png", values)
    read = read_display_png(tmp_path / "deep.png", (SIZE, SIZE))
    np.testing.assert_allclose(read, values / 65535.0, atol=1e-7)


def test_opaque_alpha_is_dropped_and_transparent_alpha_is_an_error(tmp_path):
    image = np.full((4, 6, 4), 255, dtype=np.uint8)
    image[..., :3] = 51
    write_png(tmp_path / "opaque.png", image)
    np.testing.assert_allclose(read_display_png(tmp_path / "opaque.png", (6, 4)), 0.2, atol=1e-7)
    image[1, 2:4, 3] = 254
    write_png(tmp_path / "clear.png", image)
    with pytest.raises(UserError, match=r"clear\.png has 2 transparent pixels"):
        read_display_png(tmp_path / "clear.png", (6, 4))


def test_radiance_is_shown_by_the_renderers_tone_map(single, tmp_path):
    """ACES after Narkowicz and the sRGB curve, by hand: radiance 0.18 is shown as 0.5504."""
    folder = tmp_path / "exr"
    folder.mkdir()
    for t in range(3):
        image = np.full((SIZE, SIZE, 3), 0.18, dtype=np.float32)
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": image}).write(str(folder / f"{t}.exr"))
    x = 0.18
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    shown = 1.055 * curve ** (1 / 2.4) - 0.055
    expected = [-10 * np.log10(np.square(image.astype(np.float64) - shown).mean()) for image in targets(single, 0)]
    assert psnr(single, ".exr", RadianceImages, folder).tolist() == pytest.approx(expected, abs=1e-3)


def test_targets_themselves_are_perfect(single):
    result = evaluate(Playback(4, TargetImages([single])), Metrics([PSNR()]), Protocol(Continuous()), [single])
    assert (result.frames["psnr"] == 100.0).all()


def no_frames(folder):
    for file in folder.iterdir():
        file.unlink()
    return "Clip 0 of analytic has no frames"


def missing_frame(folder):
    (folder / "shot_001.png").unlink()
    return "has no frame 1 of 0 to 2"


def missing_last_frame(folder):
    (folder / "shot_002.png").unlink()
    return "has 2 frames, but the clip has 3"


def duplicate_frame(folder):
    (folder / "shot_1.png").write_bytes((folder / "shot_001.png").read_bytes())
    return r"shot_1\.png and shot_001\.png are the same frame"


def no_number(folder):
    (folder / "shot_002.png").rename(folder / "last.png")
    return r"last\.png has no number"


def hdr_instead_of_display(folder):
    (folder / "shot_002.png").rename(folder / "shot_002.exr")
    return r"shot_002\.exr is not a \.png image.*space=radiance"


def lossy_format(folder):
    (folder / "shot_002.png").rename(folder / "shot_002.jpg")
    return r"shot_002\.jpg is not a \.png image.*export \.png images"


def different_size(folder):
    write_png(folder / "shot_001.png", np.zeros((24, SIZE, 3), dtype=np.uint8))
    return r"shot_001\.png has 48x24 pixels: .*48x48"


def one_channel(folder):
    write_png(folder / "shot_001.png", np.zeros((SIZE, SIZE, 1), dtype=np.uint8))
    return r"shot_001\.png is an image of type 8-bit grey: export it as RGB"


def truncated(folder):
    whole = (folder / "shot_001.png").read_bytes()
    (folder / "shot_001.png").write_bytes(whole[: len(whole) // 2])
    return r"shot_001\.png is truncated or damaged"


def no_image(folder):
    (folder / "shot_001.png").write_text("not a picture")
    return r"shot_001\.png is not a readable PNG image"


CHANGES = [
    *(no_frames, missing_frame, missing_last_frame, duplicate_frame, no_number),
    *(hdr_instead_of_display, lossy_format, different_size, one_channel, truncated, no_image),
]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_invalid_folders_are_errors(single, folder, change):
    message = change(folder)
    with pytest.raises(UserError, match=message):
        psnr(single, ".png", DisplayImages, folder)


def test_missing_folder_is_error(single, tmp_path):
    with pytest.raises(UserError, match="Folder .* not found"):
        clip_files(tmp_path / "nowhere", [single], ".png")
