"""NSRR's layers: their number, widths and initialisation."""

import pytest
import torch
from nsrr_transcription import nsrr

from supersampling.errors import UserError
from supersampling.models.blocks.unet import UNet
from supersampling.stages.extract import LearnedFeatures, NoExtraction
from supersampling.stages.guides import GBuffers
from supersampling.stages.reweight import LearnedWeights, NoReweighting


def parameters(model):
    return sum(p.numel() for p in model.parameters())


def by_formula(previous, width=64, extract=True, reweight=True, guides=0):
    """Count figure 4's layers, each ``(inputs, outputs)``: 9 weights per pair and a bias per output."""
    c = (12 if extract else 4) + guides
    h = width // 2
    layers = [(c * (previous + 1), width), (width, h), (h, width), (width, width), (width, 2 * width),
              (2 * width, 2 * width), (3 * width, width), (width, width), (width + h, h), (h, 3)]  # fmt: skip
    assert len(layers) == 10
    if extract:
        layers += [(4 + guides, 32), (32, 32), (32, 8)] * (2 if previous else 1)
    if reweight and previous:
        layers += [(4 * (previous + 1), 32), (32, 32), (32, previous)]
    return sum(9 * i * o + o for i, o in layers)


def test_parameters_of_the_published_network():
    assert parameters(nsrr(previous=2)) == 531_061
    assert parameters(nsrr(previous=4)) == 547_767


@pytest.mark.parametrize("previous", range(5))
@pytest.mark.parametrize(("extract", "reweight"), [(True, True), (True, False), (False, True), (False, False)])
@pytest.mark.parametrize("width", [64, 32])
def test_a_disabled_stage_leaves_no_parameters(previous, extract, reweight, width):
    model = nsrr(
        previous=previous,
        width=width,
        extract=LearnedFeatures if extract else NoExtraction,
        reweight=LearnedWeights if reweight else NoReweighting,
    )
    assert parameters(model) == by_formula(previous, width, extract, reweight)
    assert ("motion" in model.requires) == (previous > 0)
    assert model.requires - {"motion"} == {"color", "depth", "jitter"}


@pytest.mark.parametrize("previous", [0, 2])
@pytest.mark.parametrize("extract", [LearnedFeatures, NoExtraction])
def test_guides_widen_both_extractors_and_the_u_net_but_not_the_reweighting(previous, extract):
    model = nsrr(previous=previous, extract=extract, guides=GBuffers(["normal", "n_dot_v"]))
    assert parameters(model) == by_formula(previous, extract=extract is LearnedFeatures, guides=3 + 1)


def test_fast_u_net_halves_every_layer_except_the_last():
    outputs = [
        [c.out_channels for c in UNet(60, width).modules() if isinstance(c, torch.nn.Conv2d)] for width in (64, 32)
    ]
    assert outputs[0] == [64, 32, 64, 64, 128, 128, 64, 64, 32, 3]
    assert outputs[1] == [32, 16, 32, 32, 64, 64, 32, 32, 16, 3]


def test_weights_start_glorot_uniform_with_zero_biases():
    for layer in nsrr().modules():
        if isinstance(layer, torch.nn.Conv2d):
            bound = (6 / (9 * (layer.in_channels + layer.out_channels))) ** 0.5
            largest = float(layer.weight.detach().abs().max())
            assert 0.9 * bound < largest <= bound * (1 + 1e-6)
            assert not layer.bias.detach().any()


@pytest.mark.parametrize(("previous", "word"), [(-1, "-1"), (1.5, "1.5")])
def test_invalid_number_of_frames_raises(previous, word):
    with pytest.raises(UserError, match=rf"Invalid model\.previous={word}: use a whole number"):
        nsrr(previous=previous)


def test_odd_width_raises():
    with pytest.raises(UserError, match=r"Invalid model\.width=7: use an even number"):
        nsrr(width=7)
