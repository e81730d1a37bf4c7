"""LPIPS with random weights in place of the trained ones of its classifier, and without weights."""

import math
import shutil
from pathlib import Path

import lpips
import pytest
import torch
import torch.nn.functional as F
from torchvision.models.alexnet import AlexNet_Weights

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.lpips import LPIPS, trained

# AlexNet (Krizhevsky 2014): its five convolutions, numbered as torchvision does; a pool of 3, stride 2 before 3 and 6.
LAYERS = {
    0: (3, 64, 11, 4, 2),
    3: (64, 192, 5, 1, 2),
    6: (192, 384, 3, 1, 1),
    8: (384, 256, 3, 1, 1),
    10: (256, 256, 3, 1, 1),
}


def random_weights():
    g = torch.Generator().manual_seed(0)
    state = {}
    for k, (inside, outside, size, *_) in LAYERS.items():
        kernel = torch.randn(outside, inside, size, size, generator=g) / math.sqrt(inside * size * size)
        state[f"features.{k}.weight"] = kernel
        state[f"features.{k}.bias"] = 0.1 * torch.randn(outside, generator=g)
    return state


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    home = tmp_path_factory.mktemp("torch")
    folder = home / "hub" / "checkpoints"
    folder.mkdir(parents=True)
    torch.save(random_weights(), folder / AlexNet_Weights.IMAGENET1K_V1.url.rsplit("/", 1)[-1])
    yield home
    shutil.rmtree(home)


@pytest.fixture(scope="module")
def metric(home):
    trained.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TORCH_HOME", str(home))
        yield LPIPS("alex")
    trained.cache_clear()


def picture(height=48, width=64):
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return torch.stack([0.5 + 0.4 * torch.sin(0.4 * x + 0.25 * y + c) for c in range(3)])[None]


def score(metric, output, target):
    return metric(Moment(output=output, target=target))


def expected_lpips(output, target, state):
    """Zhang et al. 2018, equation 1, with the weights of each channel that the package ships."""
    learned = torch.load(Path(lpips.__file__).parent / "weights/v0.1/alex.pth", "cpu")
    shift = torch.tensor([-0.030, -0.088, -0.188]).view(3, 1, 1)
    scale = torch.tensor([0.458, 0.448, 0.450]).view(3, 1, 1)
    x, y = ((2 * image - 1 - shift) / scale for image in (output, target))
    total = 0.0
    for number, (k, (_, _, _, stride, padding)) in enumerate(LAYERS.items()):
        if k in (3, 6):
            x, y = F.max_pool2d(x, 3, 2), F.max_pool2d(y, 3, 2)
        kernel, bias = state[f"features.{k}.weight"], state[f"features.{k}.bias"]
        x, y = (F.relu(F.conv2d(i, kernel, bias, stride, padding)) for i in (x, y))
        unit = [i / i.square().sum(1, keepdim=True).sqrt() for i in (x, y)]
        weight = learned[f"lin{number}.model.1.weight"].view(1, -1, 1, 1)
        total += (weight * (unit[0] - unit[1]) ** 2).sum(1).mean().item()
    return total


def test_equals_its_equation(metric):
    g = torch.Generator().manual_seed(1)
    target = picture()
    output = (target + 0.1 * torch.randn(target.shape, generator=g)).clamp(0, 1)
    expected = expected_lpips(output, target, random_weights())
    assert metric.names == ("lpips_alex",)
    assert expected > 1e-3
    assert score(metric, output, target) == {"lpips_alex": pytest.approx(expected, abs=1e-4)}


def test_identical_and_black_frames_score_0(metric):
    for image in (picture(), torch.zeros(1, 3, 40, 40)):
        assert score(metric, image, image)["lpips_alex"] == 0.0


def test_more_noise_is_farther(metric):
    noise = torch.randn(1, 3, 48, 64, generator=torch.Generator().manual_seed(2))
    outputs = [(picture() + a * noise).clamp(0, 1) for a in (0.02, 0.06, 0.18)]
    distances = [score(metric, output, picture())["lpips_alex"] for output in outputs]
    assert 0 < distances[0] < distances[1] < distances[2]


def test_smallest_image(metric):
    assert math.isfinite(score(metric, picture(31, 31), picture(31, 31))["lpips_alex"])
    with pytest.raises(UserError, match="40x30"):
        score(metric, picture(30, 40), picture(30, 40))


def test_missing_weights_name_file_and_folder(tmp_path, monkeypatch):
    def unreachable(*_, **__):
        raise OSError("no network")

    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    monkeypatch.setattr(torch.hub, "download_url_to_file", unreachable)
    trained.cache_clear()
    url = AlexNet_Weights.IMAGENET1K_V1.url
    with pytest.raises(UserError, match="LPIPS needs") as error:
        LPIPS("alex")
    for text in (url, str(tmp_path / "hub" / "checkpoints" / url.rsplit("/", 1)[-1]), "no network"):
        assert text in str(error.value)


def test_unknown_network_is_error():
    with pytest.raises(UserError, match="network=squeeze"):
        LPIPS("squeeze")
