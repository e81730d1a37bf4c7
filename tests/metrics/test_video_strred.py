import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from video_clips import noisy, pan, score

from supersampling.errors import UserError
from supersampling.metrics.video.strred import StRred, information, luma, oriented_band


def by_hand(band):
    """Local variances and entropies of 3x3 blocks, by loops and an inverse."""
    rows, columns = band.shape[0] // 3, band.shape[1] // 3
    band = band[: 3 * rows, : 3 * columns]
    patches = [band[i : i + 3, j : j + 3].ravel() for i in range(3 * rows - 2) for j in range(3 * columns - 2)]
    centred = np.array(patches) - np.mean(patches, axis=0)
    covariance = centred.T @ centred / len(patches)
    inverse, spread = np.linalg.inv(covariance), np.linalg.eigvalsh(covariance)
    variance, entropy = np.zeros((rows, columns)), np.zeros((rows, columns))
    for i in range(rows):
        for j in range(columns):
            x = band[3 * i : 3 * i + 3, 3 * j : 3 * j + 3].ravel()
            variance[i, j] = x @ inverse @ x / 9
            entropy[i, j] = sum(math.log2(variance[i, j] * v + 0.1) + math.log(2 * math.pi * math.e) for v in spread)
    return variance, entropy


def test_information_by_hand():
    rng = np.random.default_rng(0)
    first, second = 5 * rng.standard_normal((2, 13, 17))
    (variance, entropy), (change, change_entropy) = by_hand(first), by_hand(first - second)
    spatial, temporal = information(torch.from_numpy(first), torch.from_numpy(second))
    np.testing.assert_allclose(spatial, np.log2(1 + variance) * entropy, rtol=1e-8)
    np.testing.assert_allclose(temporal, np.log2(1 + variance) * np.log2(1 + change) * change_entropy, rtol=1e-8)


def test_band_is_pyrtools():
    pyramids = pytest.importorskip("pyrtools").pyramids
    image = torch.rand(1, 112, 131, generator=torch.Generator().manual_seed(0), dtype=torch.float64) * 255
    pyramid = pyramids.SteerablePyramidSpace(image[0].numpy(), height="auto", order=5, edge_type="reflect1")
    np.testing.assert_allclose(oriented_band(image)[0], pyramid.pyr_coeffs[(3, 3)], atol=1e-9)


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
def test_equals_scikit_video(monkeypatch):
    for name, kind in (("int", int), ("float", float)):
        monkeypatch.setattr(np, name, kind, raising=False)  # scikit-video is older than numpy 2
    reference = pytest.importorskip("skvideo.measure.strred")
    double = SimpleNamespace(**{**vars(np), "float32": np.float64})  # its float32 is not enough for an inverse
    for module in (reference, sys.modules["skvideo.utils.stpyr"]):
        monkeypatch.setattr(module, "np", double)
    targets = [image.double() for image in pan(5, 112, 128)[0]]
    outputs = noisy(targets, 0.05)
    films = [np.stack([luma(f)[0].numpy() for f in clip]) for clip in (targets, outputs)]
    parts, expected, _ = reference.strred(*films)
    values = score(StRred(), outputs, targets)
    assert list(values.values()) == pytest.approx([expected, *parts[:, :2].mean(axis=0)], rel=1e-5)


def test_edges():
    black = [torch.zeros(1, 3, 48, 48)] * 2
    assert score(StRred(), black, black) == dict.fromkeys(StRred.names, 0.0)
    assert math.isnan(score(StRred(), black[:1], black[:1])["strred"])
    with pytest.raises(UserError, match="50x47"):
        score(StRred(), [torch.zeros(1, 3, 47, 50)], [torch.zeros(1, 3, 47, 50)])


def test_luma_of_white_is_255():
    assert luma(torch.ones(1, 3, 1, 1)).item() == pytest.approx(255.0)
