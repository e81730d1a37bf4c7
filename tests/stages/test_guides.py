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
        (["target"], "target"),  # the answer
        (["object_id"], "object_id"),  # a number that means nothing
        (["depth"], "depth"),  # there already
        (["normal", "albedo", "normal"], "normal"),
    ],
)
def test_what_cannot_be_added_is_refused_by_name(names, word):
    with pytest.raises(UserError, match=rf"model\.guides\.names holds {word}, .* use a list of .*normal"):
        GBuffers(names)


def test_one_name_alone_counts_as_a_list_of_it():
    assert GBuffers("normal").requires == {"normal"}
