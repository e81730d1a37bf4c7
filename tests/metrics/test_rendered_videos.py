"""Metrics of clips on a rendered clip, each against an independent implementation."""

import json
import subprocess
import sys
from itertools import groupby, pairwise

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import map_coordinates
from video_clips import score

from supersampling.metrics.video.base import to_bytes
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError


def clip_score(metric, film, outputs=None):
    return score(metric, outputs or film.outputs, film.targets, film.motions, film.duals)


def stack(images):
    """``(T, H, W, C)``, float64."""
    return np.stack([image[0].permute(1, 2, 0).double().numpy() for image in images])


def upsampled(vectors, height, width):
    """By scipy, in pixels: ``(T, H, W, 2)``, x before y."""
    y, x = np.mgrid[0:height, 0:width] + 0.5
    frames = []
    for low in stack(vectors):
        places = (y * low.shape[0] / height - 0.5, x * low.shape[1] / width - 0.5)
        planes = [map_coordinates(low[..., k], places, order=1, mode="nearest") for k in range(2)]
        frames.append(np.stack(planes, axis=-1) * (width, height))
    return np.stack(frames)


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
def test_strred_equals_scikit_video(film, monkeypatch):
    for name, kind in (("int", int), ("float", float)):
        monkeypatch.setattr(np, name, kind, raising=False)  # scikit-video is older than numpy 2
    reference = pytest.importorskip("skvideo.measure.strred")
    films = [255 * stack(clip) @ (0.2126, 0.7152, 0.0722) for clip in (film.targets, film.outputs)]
    parts, expected, _ = reference.strred(*films)
    values = clip_score(StRred(), film)
    assert expected > 10
    assert list(values.values()) == pytest.approx([expected, *parts[:, :2].mean(axis=0)], rel=1e-4)


def test_vmaf_equals_ffmpeg_on_png_files(film, tmp_path):
    """The usual comparison of two folders of screenshots; this project only states BT.709."""
    inputs = []
    for name, clip in (("output", film.outputs), ("target", film.targets)):
        for t, frame in enumerate(clip):
            Image.fromarray(to_bytes(frame)).save(tmp_path / f"{name}_{t}.png")
        inputs += ["-framerate", "60", "-i", f"{name}_%d.png"]
    to_yuv = "scale=out_color_matrix=bt709:out_range=tv:flags=bicubic+accurate_rnd,format=yuv420p"
    graph = f"[0:v]{to_yuv}[a];[1:v]{to_yuv}[b];[a][b]libvmaf=log_fmt=json:log_path=log.json"
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", *inputs, "-lavfi", graph, "-f", "null", "-"]
    subprocess.run(command, cwd=tmp_path, check=True)
    expected = json.loads((tmp_path / "log.json").read_text())["pooled_metrics"]["vmaf"]["mean"]
    assert 1 < expected < 95
    assert clip_score(Vmaf(), film)["vmaf"] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(
    ("rate", "display"), [(60.0, "standard_fhd"), pytest.param(30.0, "standard_4k", marks=pytest.mark.slow)]
)
def test_colorvideovdp_equals_its_command_line(film, tmp_path, rate, display):
    pytest.importorskip("pycvvdp")
    for name, clip in (("output", film.outputs), ("target", film.targets)):
        for t, frame in enumerate(clip):
            # The tool wants a library for PNG that it would download.
            Image.fromarray(to_bytes(frame)).save(tmp_path / f"{name}_{t:03}.bmp")
    command = [sys.executable, "-m", "pycvvdp.run_cvvdp", "--test", "output_%03d.bmp", "--ref", "target_%03d.bmp"]
    command += ["--fps", f"{rate:g}", "--display", display, "--device", "cpu", "--quiet", "--result", "score.csv"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    expected = float((tmp_path / "score.csv").read_text().split(",")[-1])
    assert 1 < expected < 9.9
    (value,) = clip_score(ColorVideoVdp(rate, display), film).values()
    assert value == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("kind", ["dual", "photometric"])
def test_warping_errors_equal_scipys_interpolation(film, kind):
    outputs, targets = stack(film.outputs), stack(film.targets)
    height, width = targets.shape[1:3]
    motion, dual = upsampled(film.motions, height, width), upsampled(film.duals, height, width)
    y, x = np.mgrid[0:height, 0:width].astype(float)
    pairs = []
    for before, now in pairwise(range(len(targets))):
        places = (y + motion[now, ..., 1], x + motion[now, ..., 0])
        seen = (abs(places[0] - (height - 1) / 2) <= height / 2) & (abs(places[1] - (width - 1) / 2) <= width / 2)

        def warped(frame, places=places):
            planes = [map_coordinates(frame[..., c], places, order=1, mode="nearest") for c in range(3)]
            return np.stack(planes, axis=-1)

        if kind == "dual":
            weight = seen & (abs(dual[now] - motion[now]).max(axis=-1) < 0.1 * 4)
        else:
            weight = seen * np.exp(-50 * ((targets[now] - warped(targets[before])) ** 2).sum(axis=-1))
        total = 3 * weight.sum()
        pairs.append(
            [((clip[now] - warped(clip[before])) ** 2 * weight[..., None]).sum() / total for clip in (outputs, targets)]
        )
    output, reference = np.mean(pairs, axis=0)
    values = clip_score(WarpingError({"dual": DualMotion, "photometric": Photometric}[kind]()), film)
    assert 0 < reference < output
    assert list(values.values()) == pytest.approx([output, reference, output / reference], rel=2e-3)


def test_static_deviation_equals_numpys(film):
    """Every pixel's runs of 3 frames or more without motion."""
    outputs, targets = stack(film.outputs), stack(film.targets)
    count, height, width = targets.shape[:3]
    still = (abs(upsampled(film.motions, height, width)) < 0.01).all(axis=-1)
    sums, weight = np.zeros(2), 0
    for i in range(height):
        for j in range(width):
            for rests, group in groupby(range(count), key=lambda t, i=i, j=j: still[t, i, j]):
                span = list(group)
                if rests and len(span) >= 3:
                    sums += [len(span) * clip[span, i, j].std(axis=0).mean() for clip in (outputs, targets)]
                    weight += len(span)
    expected = [*(255 * sums / weight), weight / still.size]
    assert 0.5 < expected[2] < 0.95
    assert expected[0] > 2 * expected[1] > 0.0
    assert list(clip_score(StaticDeviation(3), film).values()) == pytest.approx(expected, rel=1e-3)
