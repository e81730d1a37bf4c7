"""Known faults: a stronger fault is worse by every metric, and metrics are blind to the faults that docs/metrics.md
lists."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from supersampling.metrics.base import FrameSuite, Moment
from supersampling.metrics.flip import FLIP, FLIPHDR
from supersampling.metrics.radiance import PSNRMu
from supersampling.metrics.still import PSNR, SSIM, SSIMUniform11, SSIMZeroPad11
from supersampling.ops.display import radiance_to_display

PAGE = Path(__file__).resolve().parents[2] / "docs" / "metrics.md"
SSIMS = {"ssim", "ssim_uniform11", "ssim_zero_pad11"}
BLIND: dict[str, set[str]] = {
    "noise": set(),
    "brighter": SSIMS,
    "a blue tint": SSIMS,
    "a pattern of single pixels": {"flip"},
    "swapped channels": set(),
    "highlights beyond white": {"psnr", "flip"} | SSIMS,
    "wrong tone map": {"psnr_hdr_mu", "flip_hdr"},
}
RMS = 0.05
SAME_RMS = ("noise", "brighter", "a blue tint", "a pattern of single pixels")

DISPLAY = FrameSuite([PSNR(), SSIM(), SSIMUniform11(), SSIMZeroPad11(), FLIP()])
RADIANCE = FrameSuite([PSNRMu(1.0), FLIPHDR(start=-3, stop=3, number=6)])

_rng = np.random.default_rng(0)
Y, X = np.mgrid[0:72, 0:96]
PICTURE = np.stack(
    [0.45 + 0.2 * np.sin(0.35 * X + c) * np.cos(0.22 * Y) + 0.15 * ((X // 12 + Y // 9) % 2) for c in range(3)]
)
PICTURE = np.clip(PICTURE + 0.03 * gaussian_filter(_rng.standard_normal(PICTURE.shape), (0, 0.7, 0.7)), 0, 1)
NOISE = _rng.standard_normal(PICTURE.shape)
LIGHT = np.where(PICTURE <= 0.04045, PICTURE / 12.92, ((PICTURE + 0.055) / 1.055) ** 2.4)


def tensor(image):
    return torch.from_numpy(np.ascontiguousarray(image, np.float32))[None]


def shown(radiance):
    return radiance_to_display(tensor(radiance))[0].numpy()


def display_scores(output, target):
    return DISPLAY(Moment(output=tensor(output), target=tensor(target)))


def radiance_scores(output, target):
    zeros = torch.zeros(1, 3, 1, 1)
    return RADIANCE(Moment(output=zeros, target=zeros, radiance=(tensor(output), tensor(target))))


def loss(name, value):
    """Return the loss: 0 for identical images, more is worse."""
    if name.startswith("psnr"):
        return 10 ** (-value / 20)
    return 1 - value if "ssim" in name else value


DEGRADE = {
    "blur": (lambda image, a: gaussian_filter(image, (0, a, a)), (0.5, 1.0, 2.0)),
    "noise": (lambda image, a: image + a * NOISE, (0.02, 0.05, 0.1)),
    "shift": (lambda image, a: np.roll(image, a, axis=2), (1, 2, 3)),
}


@pytest.mark.parametrize("kind", DEGRADE)
def test_stronger_degradation_is_worse_by_every_metric(kind):
    degrade, amounts = DEGRADE[kind]
    rows = [
        display_scores(np.clip(degrade(PICTURE, a), 0, 1), PICTURE)
        | radiance_scores(np.clip(degrade(LIGHT, a), 0, None), LIGHT)
        for a in amounts
    ]
    for name in rows[0]:
        losses = [loss(name, row[name]) for row in rows]
        assert 1e-3 < losses[0] < losses[1] < losses[2], name


@pytest.fixture(scope="module")
def scores():
    """Return the scores of every fault in `BLIND`, for display images and, if the fault is one of light, for
    radiance."""
    middle = 0.2 + 0.6 * PICTURE
    blue = np.zeros_like(PICTURE)
    blue[2] = math.sqrt(3)
    added = {
        "noise": NOISE / np.sqrt((NOISE**2).mean()),
        "brighter": np.ones_like(PICTURE),
        "a blue tint": blue,
        "a pattern of single pixels": np.broadcast_to((X + Y) % 2 * 2.0 - 1, PICTURE.shape),
    }
    values = {name: display_scores(middle + RMS * error, middle) for name, error in added.items()}
    values["swapped channels"] = display_scores(middle[::-1], middle)
    bright, dimmer = LIGHT.copy(), LIGHT.copy()
    bright[:, :20, :20], dimmer[:, :20, :20] = 40, 20
    values["highlights beyond white"] = {
        **display_scores(shown(dimmer), shown(bright)),
        **radiance_scores(dimmer, bright),
    }
    gamma = np.clip(LIGHT, 0, 1) ** (1 / 2.2)
    values["wrong tone map"] = {**display_scores(gamma, shown(LIGHT)), **radiance_scores(LIGHT, LIGHT)}
    return values


@pytest.mark.parametrize("fault", BLIND)
def test_metrics_blind_to_each_fault(fault, scores):
    """Blind: a loss near zero, or at most an eighth of that of an error of the same RMS."""
    for name, value in scores[fault].items():
        most = max(loss(name, scores[f][name]) for f in SAME_RMS) / 8 if fault in SAME_RMS else 0.0
        if name in BLIND[fault]:
            assert loss(name, value) < max(most, 1e-4), (name, value)
        else:
            assert loss(name, value) > max(most, 1e-2), (name, value)


def test_psnr_is_blind_to_errors_pattern(scores):
    for fault in SAME_RMS:
        assert scores[fault]["psnr"] == pytest.approx(-20 * math.log10(RMS), abs=1e-3)


def test_documentation_has_these_numbers_and_marks_blind_metrics(scores):
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.read_text().splitlines()]
    head = next([re.sub("`", "", cell) for cell in line] for line in lines if line[0] == "fault")
    rows = {line[0]: dict(zip(head[1:], line[1:])) for line in lines if line[0] in BLIND}
    assert rows.keys() == BLIND.keys()
    for fault, row in rows.items():
        for name, cell in row.items():
            if name not in scores[fault]:
                assert cell == ""
                continue
            text = cell.strip("*")
            digits = len(text.partition(".")[2])
            assert (cell != text) == (name in BLIND[fault]), (fault, name)
            assert float(text) == pytest.approx(scores[fault][name], abs=0.51 * 10**-digits), (fault, name)
