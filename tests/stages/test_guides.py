import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.stages.guides import GBuffers, NoGuides


def test_none_reads_nothing_and_adds_nothing():
    samples, stage = torch.rand(2, 4, 3, 5), NoGuides()
    assert torch.equal(stage(samples, Frame()), samples)
    assert stage.channels == 0
    assert stage.requires == frozenset()


def test_buffers_follow_the_samples_in_the_order_of_their_names():
    samples, albedo, roughness = torch.rand(2, 4, 3, 5), torch.rand(2, 3, 3, 5), torch.rand(2, 1, 3, 5)
    stage = GBuffers(["roughness", "albedo"])
    out = stage(samples, Frame(albedo=albedo, roughness=roughness))
    assert out.shape == (2, 4 + stage.channels, 3, 5)
    assert torch.equal(out[:, :4], samples)
    assert torch.equal(out[:, 4:5], roughness)
    assert torch.equal(out[:, 5:], albedo)
    assert stage.requires == {"albedo", "roughness"}


@pytest.mark.parametrize(
    ("names", "word"),
    [
        (["normals"], "normals"),  # no buffer at all
        (["normal", "high_normal"], "high_normal"),  # of the target resolution
        (["jitter"], "jitter"),  # no image
        (["target"], "target"),  # the reference
        (["object_id"], "object_id"),  # a number without a meaning
        (["depth"], "depth"),  # always an input
        (["normal", "albedo", "normal"], "normal"),
    ],
)
def test_invalid_guides_raise_by_name(names, word):
    with pytest.raises(UserError, match=rf"Invalid entry {word} of model\.guides\.names, .*: use a list of .*normal"):
        GBuffers(names)


def test_single_name_counts_as_a_list():
    assert GBuffers("normal").requires == {"normal"}
