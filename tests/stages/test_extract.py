"""Feature extraction against convolutions written as loops."""

import torch

from supersampling.stages.extract import LearnedFeatures, NoExtraction


def convolved(image, weight, bias):
    """Convolve 3x3 with zeros outside, one output pixel after the other."""
    channels, height, width = image.shape
    out = torch.zeros(len(weight), height, width, dtype=image.dtype)
    for o in range(len(weight)):
        for i in range(height):
            for j in range(width):
                total = bias[o].clone()
                for c in range(channels):
                    for y in range(max(0, i - 1), min(height, i + 2)):
                        for x in range(max(0, j - 1), min(width, j + 2)):
                            total += weight[o, c, y - i + 1, x - j + 1] * image[c, y, x]
                out[o, i, j] = total
    return out


@torch.no_grad()
def test_learned_features_follow_the_samples():
    torch.manual_seed(0)
    stage = LearnedFeatures(4, width=3, features=2).double()
    samples = torch.rand(1, 4, 3, 4, dtype=torch.float64)
    x = samples[0]
    for layer in stage.network[::2]:
        x = convolved(x, layer.weight, layer.bias).clamp_min(0.0)
    out = stage(samples)
    assert stage.channels == out.shape[1] == 6
    assert torch.equal(out[:, :4], samples)
    torch.testing.assert_close(out[0, 4:], x, rtol=0, atol=1e-14)


def test_published_widths():
    stage = LearnedFeatures(4)
    assert [(c.in_channels, c.out_channels, c.kernel_size) for c in stage.network[::2]] == [
        (4, 32, (3, 3)),
        (32, 32, (3, 3)),
        (32, 8, (3, 3)),
    ]
    assert stage.channels == 12
    assert sum(p.numel() for p in stage.parameters()) == 12_744


def test_two_extractors_share_no_weights():
    first, second = LearnedFeatures(4), LearnedFeatures(4)
    assert not {p.data_ptr() for p in first.parameters()} & {p.data_ptr() for p in second.parameters()}


def test_gradients():
    torch.manual_seed(1)
    stage = LearnedFeatures(2, width=3, features=2).double()
    x = torch.rand(1, 2, 3, 3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(stage, (x,))


def test_none_returns_the_samples_and_has_no_parameters():
    stage, samples = NoExtraction(4), torch.rand(2, 4, 3, 5)
    assert stage(samples) is samples
    assert stage.channels == 4
    assert not list(stage.parameters())
