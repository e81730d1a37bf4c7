"""Damaged checkpoints give the weights that were written, or one sentence."""

import lightning as L
import numpy as np
import pytest
import torch
from fuzzing import attempt, is_sentence, mutate, trials
from torch import nn

from supersampling.errors import UserError
from supersampling.runs.checkpoint import KEY, load_weights, read_metadata
from supersampling.runs.checkpoint_file import load_checkpoint
from supersampling.training.resume import PARTS, resume_checkpoint


class Module(L.LightningModule):
    def __init__(self) -> None:
        super().__init__()
        self.model = nn.Sequential(nn.Conv2d(3, 4, 3), nn.Conv2d(4, 2, 1))


@pytest.mark.slow
def test_fuzz_checkpoint(tmp_path):
    torch.manual_seed(0)
    module, path = Module(), tmp_path / "last.ckpt"
    metadata = {"model": {"option": "jau"}, "task": {"scale": 2}, "run": "r1"}
    torch.save({"state_dict": module.state_dict(), KEY: metadata, **dict.fromkeys(PARTS, 0)}, path)
    content = path.read_bytes()

    def check() -> None:
        model = Module().model
        try:
            entry = read_metadata(path)
            load_weights(model, path)
            resumed = resume_checkpoint(path, module)
        except UserError as error:
            is_sentence(error)
            return
        assert entry == metadata
        assert resumed == path
        assert {part: load_checkpoint(path)[part] for part in PARTS} == dict.fromkeys(PARTS, 0)
        for name, value in module.model.state_dict().items():
            assert torch.equal(model.state_dict()[name], value)

    for seed in trials():
        path.write_bytes(mutate(content, np.random.default_rng(seed)))
        attempt(seed, path, tmp_path / f"failure{seed}.ckpt", check)
        if seed % 4 == 0:  # a broken one is set aside
            path.write_bytes(mutate(content, np.random.default_rng(seed)))
            attempt(seed, path, tmp_path / f"failure{seed}.ckpt", lambda: resume_or_refuse(path, module))


def resume_or_refuse(path, module):
    try:
        resumed = resume_checkpoint(path, module)
    except UserError as error:
        is_sentence(error)
        return
    assert resumed in (None, path)
    assert path.exists() == (resumed == path)
