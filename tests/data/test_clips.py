import re

import numpy as np
import pytest
import torch

from supersampling.data.augment import NoAugmentation
from supersampling.data.clips import Cut, EqualShares, FreshIndices, Share, WholeClips, WindowDataset
from supersampling.data.pick import Uniform
from supersampling.errors import UserError

PLAIN = NoAugmentation()
UNIFORM = Uniform()
ALL = frozenset({"color", "depth", "motion", "jitter"})


def test_items_have_the_shape_of_the_cut_and_depend_on_their_index_only(make_file, tmp_path):
    path = make_file(tmp_path)
    data = WindowDataset([path], Cut(crop=32, frames=6, targets=3), ALL, UNIFORM, PLAIN, seed=1)
    item = data[17]
    assert item["color"].shape == (6, 3, 8, 8)
    assert item["jitter"].shape == (6, 2)
    assert item["target"].shape == (3, 3, 32, 32)
    data[3]
    again = WindowDataset([path], Cut(crop=32, frames=6, targets=3), ALL, UNIFORM, PLAIN, seed=1)[17]
    for name, value in item.items():
        assert torch.equal(value, again[name])


def test_name_states_file_clip_and_window(make_file, tmp_path):
    path = make_file(tmp_path, clips=3)
    data = WindowDataset([path], Cut(crop=32, frames=2, targets=2), ALL, UNIFORM, PLAIN, seed=1)
    whole = WholeClips([path], ALL)
    for index in range(6):
        pattern = r"(\S+) clip (\d), frames (\d+) to (\d+), at \((\d+), (\d+)\)"
        scene, *numbers = re.fullmatch(pattern, data.name(index)).groups()
        clip, first, last, x, y = map(int, numbers)
        assert scene == whole.name(clip).scene
        color = whole[clip]["color"][first : last + 1, :, y : y + 8, x : x + 8]
        assert torch.equal(data[index]["color"], color)


def test_clips_in_memory_equal_clips_on_disk(make_file, tmp_path):
    path = make_file(tmp_path, clips=3)
    in_memory, on_disk = (
        WindowDataset([path], Cut(crop=32, frames=5, targets=3), ALL, UNIFORM, PLAIN, seed=1, memory_limit=limit)
        for limit in (1 << 30, 0)
    )
    for index in range(4):
        for name, value in on_disk[index].items():
            assert torch.equal(value, in_memory[index][name])


def test_input_and_target_windows_match(make_file, tmp_path):
    """A still pattern: the low sample at jitter j is the target's pixel at floor((j + 0.5) * scale), nearly."""
    data = WindowDataset([make_file(tmp_path)], Cut(crop=32, frames=1, targets=1), ALL, UNIFORM, PLAIN, seed=0)
    for index in range(5):
        item = data[index]
        x, y = torch.floor((item["jitter"][0] + 0.5) * 4).int().tolist()
        expected = item["target"][0][:, y::4, x::4]
        assert (item["color"][0] - expected).abs().max() <= 1.01 / 255


def test_only_required_buffers_are_read(make_file, tmp_path):
    data = WindowDataset([make_file(tmp_path)], Cut(32, 4, 2), frozenset({"color"}), UNIFORM, PLAIN, seed=0)
    assert set(data[0]) == {"color", "target"}


def test_cut_larger_than_clips_is_an_error(make_file, tmp_path):
    path = make_file(tmp_path)
    with pytest.raises(UserError, match="budget.crop=64"):
        WindowDataset([path], Cut(64, 4, 2), ALL, UNIFORM, PLAIN, seed=0)
    with pytest.raises(UserError, match="budget.frames=9"):
        WindowDataset([path], Cut(32, 9, 2), ALL, UNIFORM, PLAIN, seed=0)


def test_no_epoch_repeats_index():
    sampler = FreshIndices(5)
    seen = []
    for epoch in range(3):
        sampler.set_epoch(epoch)
        seen += list(sampler)
    assert seen == list(range(15))


@pytest.mark.parametrize("processes", [1, 2, 3, 6])
def test_the_windows_of_a_step_do_not_depend_on_the_number_of_processes(processes):
    batch, steps = 6, 4
    samplers = [FreshIndices(batch * steps, batch, Share(rank, processes)) for rank in range(processes)]
    for epoch in range(2):
        for sampler in samplers:
            sampler.set_epoch(epoch)
        shares = np.array([list(sampler) for sampler in samplers]).reshape(processes, steps, batch // processes)
        assert [len(sampler) for sampler in samplers] == [batch * steps // processes] * processes
        for step in range(steps):
            first = (epoch * steps + step) * batch
            assert shares[:, step].flatten().tolist() == list(range(first, first + batch))


@pytest.mark.parametrize("size", [1, 2, 5, 6])
@pytest.mark.parametrize("processes", [1, 2, 3, 8])
def test_shares_of_clips_are_equally_long_and_no_clip_counts_twice(size, processes):
    samplers = [EqualShares(size, Share(rank, processes)) for rank in range(processes)]
    shares = [list(sampler) for sampler in samplers]
    assert {len(share) for share in shares} == {len(sampler) for sampler in samplers} == {-(-size // processes)}
    counted = [k for share, s in zip(shares, samplers) for p, k in enumerate(share) if not s.repeats(p)]
    assert sorted(counted) == list(range(size))
    assert all(0 <= k < size for share in shares for k in share)


def test_whole_clips_come_in_order(make_file, tmp_path):
    clips = WholeClips([make_file(tmp_path, clips=3, frames=5)], frozenset({"color", "motion"}))
    names = [name.clip for name, _ in clips]
    assert names == [0, 1, 2]
    assert clips[2]["target"].shape == (5, 3, 48, 48)
    assert np.isfinite(clips[2]["motion"].numpy()).all()
