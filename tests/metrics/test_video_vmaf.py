import json
import math
import subprocess

import imageio_ffmpeg
import numpy as np
import pytest
import torch
from video_clips import blurred, moments, noisy, pan, score

from supersampling.errors import UserError
from supersampling.metrics.video.base import to_bytes
from supersampling.metrics.video.vmaf import Vmaf


def write_y4m(path, frames):
    """Write BT.709 of video range by its formulas, in grey: the model reads no colour."""
    height, width = frames[0].shape[-2:]
    with open(path, "wb") as file:
        file.write(f"YUV4MPEG2 W{width} H{height} F30:1 Ip A1:1 C420\n".encode())
        for frame in frames:
            red, green, blue = to_bytes(frame).astype(float).transpose(2, 0, 1) / 255
            y = 16 + 219 * (0.2126 * red + 0.7152 * green + 0.0722 * blue)
            file.write(b"FRAME\n" + np.rint(y).astype(np.uint8).tobytes() + b"\x80" * (height * width // 2))


def libvmaf(folder, output, target):
    """ffmpeg's score of two files."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", *output, *target]
    command += ["-lavfi", "[0:v][1:v]libvmaf=log_fmt=json:log_path=log.json", "-f", "null", "-"]
    subprocess.run(command, cwd=folder, check=True)
    return json.loads((folder / "log.json").read_text())["pooled_metrics"]["vmaf"]["mean"]


@pytest.fixture
def film():
    targets, _ = pan(5, 48, 64)
    return noisy(blurred(targets, 1), 0.03), targets


def test_equals_ffmpeg_on_two_files(film, tmp_path):
    for name, frames in zip(("output.y4m", "target.y4m"), film):
        write_y4m(tmp_path / name, frames)
    expected = libvmaf(tmp_path, ["-i", "output.y4m"], ["-i", "target.y4m"])
    assert 5 < expected < 95
    # swscale rounds its conversion differently from the formulas.
    assert score(Vmaf(), *film)["vmaf"] == pytest.approx(expected, abs=0.2)


def test_equals_ffmpeg_on_lossless_rgb_files(film, tmp_path):
    """The same conversion with separate files: nothing is mixed up or lost in the transfer through stdin."""
    convert = "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:flags=bicubic+accurate_rnd,format=yuv420p"
    for name, frames in zip(("output", "target"), film):
        (tmp_path / f"{name}.raw").write_bytes(b"".join(to_bytes(f).tobytes() for f in frames))
        source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "64x48", "-r", "30", "-i", f"{name}.raw"]
        sink = ["-vf", convert, "-c:v", "ffv1", f"{name}.mkv"]
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", *source, *sink]
        subprocess.run(command, cwd=tmp_path, check=True)
    expected = libvmaf(tmp_path, ["-i", "output.mkv"], ["-i", "target.mkv"])
    assert score(Vmaf(), *film)["vmaf"] == pytest.approx(expected, abs=1e-5)


def test_odd_sizes_and_known_values():
    still = [torch.rand(1, 3, 33, 35, generator=torch.Generator().manual_seed(0))] * 3
    assert score(Vmaf(), still, still)["vmaf"] == pytest.approx(97.43, abs=0.01)
    assert math.isnan(score(Vmaf(), [], [])["vmaf"])


def test_user_errors():
    small, image = torch.zeros(1, 3, 31, 40), torch.zeros(1, 3, 32, 32)
    with pytest.raises(UserError, match="40x31"):
        score(Vmaf(), [small], [small])
    with pytest.raises(UserError, match="no_such_model"):
        score(Vmaf("no_such_model"), [image], [image])


def test_unfinished_clip_leaves_no_process(film):
    scoring = Vmaf().begin()
    scoring.add(next(moments(*film)))
    process = scoring._process
    scoring.close()
    scoring.close()
    assert process.returncode is not None
