from itertools import pairwise

import numpy as np
import pytest
import torch
import torchvision
from scipy.signal import correlate2d
from torchvision.models.vgg import cfgs, make_layers

from supersampling.errors import UserError
from supersampling.losses import Perceptual, Sum, perceptual
from supersampling.losses.perceptual import LAYERS, Pretrained

MEAN, DEVIATION = (0.4, 0.5, 0.6), (0.2, 0.25, 0.3)
NAMED = ("relu1_2", "relu2_2", "relu3_3", "relu4_3", "relu5_3")


def tiny():
    """Return weights and biases of a VGG-16 with 2 to 4 channels instead of 64 to 512; random biases, half negative."""
    rng = np.random.default_rng(0)
    widths = [3, *([2] * 2), *([3] * 2), *([4] * 9)]
    return [(rng.normal(size=(b, a, 3, 3)) / 3, rng.normal(size=b) * 0.3) for a, b in pairwise(widths)]


@pytest.fixture
def small(monkeypatch):
    pairs = tuple((torch.from_numpy(k).float(), torch.from_numpy(b).float()) for k, b in tiny())
    monkeypatch.setattr(perceptual, "pretrained", lambda weights: Pretrained(pairs, MEAN, DEVIATION))


def activations(image):
    """Compute every layer of the tiny network by scipy's correlation, for an image ``(3, H, W)``."""
    x = (image - np.array(MEAN)[:, None, None]) / np.array(DEVIATION)[:, None, None]
    layers = {}
    for name, (kernel, bias) in zip(LAYERS, tiny()):
        if name in ("relu2_1", "relu3_1", "relu4_1", "relu5_1"):
            c, h, w = x.shape
            x = x[:, : h // 2 * 2, : w // 2 * 2].reshape(c, h // 2, 2, w // 2, 2).max(axis=(2, 4))
        x = np.stack(
            [sum(correlate2d(x[a], k[a], mode="same") for a in range(len(x))) + b for k, b in zip(kernel, bias)]
        )
        x = layers[name] = np.maximum(x, 0.0)
    return layers


@pytest.mark.parametrize("layers", [NAMED, ("relu2_2",), ("relu3_1", "relu1_1")])
def test_loss_equals_equation_1_with_means_as_norms(small, layers):
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 2, 2, 3, 19, 34))
    expected = 0.0
    pairs = [(activations(a), activations(b)) for a, b in zip(x.reshape(-1, 3, 19, 34), y.reshape(-1, 3, 19, 34))]
    for name in layers:
        expected += np.mean([np.mean((a[name] - b[name]) ** 2) for a, b in pairs])
    loss = Perceptual(layers, "any")
    value = loss(torch.from_numpy(x).float(), torch.from_numpy(y).float(), {})
    assert value.item() == pytest.approx(expected, rel=1e-4)
    assert (loss.requires, loss.previous) == (frozenset(), 0)


def test_weights_are_neither_learned_nor_saved(small):
    loss = Sum({"perceptual": lambda: Perceptual(NAMED, "any")}, {"perceptual": 0.1})
    assert not list(loss.parameters())
    assert not loss.state_dict()
    assert len(list(loss.buffers())) == 2 + 2 * 13


def test_gradients_reach_only_the_output_and_are_finite_for_equal_images(small):
    torch.manual_seed(0)
    y = torch.rand(1, 2, 3, 16, 16, requires_grad=True)
    x = y.detach().clone().requires_grad_()
    loss = Perceptual(NAMED, "any")(x, y, {})
    loss.backward()
    assert loss.item() == 0.0
    assert x.grad.isfinite().all()
    assert y.grad is None
    Perceptual(NAMED, "any")(x + 0.1, y, {}).backward()
    assert x.grad.abs().max() > 0


def test_layers_equal_torchvision():
    """Names and order agree with torchvision's network with random weights."""
    torch.manual_seed(0)
    layers = make_layers(cfgs["D"])
    convolutions = [m for m in layers if isinstance(m, torch.nn.Conv2d)]
    assert len(convolutions) == len(LAYERS)
    network = Pretrained(tuple((m.weight.detach(), m.bias.detach()) for m in convolutions), (0.0,) * 3, (1.0,) * 3)
    image = torch.rand(1, 3, 32, 32)
    with torch.no_grad(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(perceptual, "pretrained", lambda weights: network)
        features = Perceptual(NAMED, "any").features(image)
        # The usual indices in torchvision of relu1_2, relu2_2, relu3_3, relu4_3 and relu5_3.
        for index, feature in zip((3, 8, 15, 22, 29), features):
            torch.testing.assert_close(feature, layers[: index + 1](image))


def test_failed_download_names_file_and_folder(monkeypatch, tmp_path):
    def offline(*args, **kwargs):
        raise OSError("<urlopen error no route to host>")

    monkeypatch.setattr(torch.hub, "download_url_to_file", offline)
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    with pytest.raises(UserError, match=f"vgg16-397923af.pth at {tmp_path}/hub/checkpoints/vgg16-397923af.pth"):
        Perceptual(NAMED, "IMAGENET1K_V1")


@pytest.mark.parametrize("content", [b"", b"half a download", None], ids=["empty", "corrupt", "different network"])
def test_corrupt_file_is_named(monkeypatch, tmp_path, content):
    path = tmp_path / "hub" / "checkpoints" / "vgg16-397923af.pth"
    path.parent.mkdir(parents=True)
    if content is None:
        torch.save({"features.0.weight": torch.zeros(1)}, path)
    else:
        path.write_bytes(content)
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    with pytest.raises(UserError, match="vgg16-397923af.pth"):
        Perceptual(NAMED, "IMAGENET1K_V1")


def test_existing_file_is_loaded(monkeypatch, tmp_path):
    path = tmp_path / "hub" / "checkpoints" / "vgg16-397923af.pth"
    path.parent.mkdir(parents=True)
    torch.manual_seed(0)
    torch.save({f"features.{k}": v for k, v in make_layers(cfgs["D"]).state_dict().items()}, path)
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    perceptual.pretrained.cache_clear()
    try:
        network = perceptual.pretrained("IMAGENET1K_V1")
    finally:
        perceptual.pretrained.cache_clear()
    preset = torchvision.models.VGG16_Weights.IMAGENET1K_V1.transforms()
    assert (list(network.mean), list(network.deviation)) == (preset.mean, preset.std)
    assert sum(k.numel() + b.numel() for k, b in network.convolutions) == 14_714_688


def test_invalid_layers_and_crops_are_rejected(small):
    with pytest.raises(UserError, match="relu6_1"):
        Perceptual(["relu6_1"], "any")
    with pytest.raises(UserError, match="layers"):
        Perceptual([], "any")
    image = torch.zeros(1, 1, 3, 15, 40)
    with pytest.raises(UserError, match="Crops of 40x15 pixels are too small .* at least 16"):
        Perceptual(NAMED, "any")(image, image, {})
    assert Perceptual(["relu4_3"], "any")(image, image, {}).item() == 0.0


def test_unknown_weights_are_rejected():
    with pytest.raises(UserError, match="IMAGENET1K_V1"):
        Perceptual(NAMED, "IMAGENET22K")
