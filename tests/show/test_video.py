"""Videos are decoded again and compared with what went in."""

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image, ImageSequence
from show_files import FRAMES, write

from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.show.clip import ClipView
from supersampling.show.video import check_format, video_frames, write_video


def decoded(path):
    """Rate and frames of an MP4."""
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    width, height = about["size"]
    return about, [np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3) for frame in reader]


@pytest.fixture
def clip(tmp_path):
    file = DatasetFile(write(tmp_path))
    yield ClipView(file, 1)
    file.close()


def test_mp4(clip, tmp_path):
    frames = list(video_frames(clip, 4, (128, 96), "made up"))
    path = tmp_path / "clip.mp4"
    write_video(path, frames, 24.0)
    about, played = decoded(path)
    assert (about["codec"], about["fps"]) == ("h264", 24.0)
    assert len(played) == len(frames) == FRAMES
    assert played[0].shape == frames[0].shape
    error = [np.abs(a.astype(float) - b).mean() for a, b in zip(played, frames)]
    other = np.abs(played[0].astype(float) - frames[-1]).mean()
    assert max(error) < 0.5 * other


def test_webp(clip, tmp_path):
    frames = list(video_frames(clip, 4, (64, 48), "made up"))
    path = tmp_path / "clip.webp"
    write_video(path, frames, 10.0)
    with Image.open(path) as image:
        played = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)]
        assert image.info["duration"] == 100
    assert len(played) == FRAMES
    assert played[0].shape == frames[0].shape


def test_frames_without_target_keep_the_layout(clip):
    first, *_, last = video_frames(clip, 4, (64, 48), "made up")
    assert first.shape == last.shape
    assert (first == (58, 58, 58)).all(axis=2).sum() >= 2 * 64 * 48  # target and warp error
    assert (last == (58, 58, 58)).all(axis=2).sum() < 64 * 48


def test_another_format_is_error():
    with pytest.raises(UserError, match="video=avi"):
        check_format("avi")
