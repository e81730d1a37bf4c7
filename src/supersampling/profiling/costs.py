"""What each backend and precision changes in the quality of one method's weights, as a table to log beside its times."""

import copy
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor

from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError
from supersampling.evaluation.score import whole_clips
from supersampling.metrics.prepare import Prepare
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, Setting
from supersampling.profiling.drift import Player, Variant, first_clips, roll
from supersampling.runs.experiment import machine

Wanted = Sequence[tuple[Backend, str]]  # each with a precision


def measure(
    model: Upsampler,
    wanted: Wanted,
    files: Sequence[Path],
    prepare: Prepare,
    jitters: Tensor | None,
    threads: int,
    every_clip: bool = False,
) -> tuple[pd.DataFrame, dict[Variant, str]]:
    """The table of `roll` with the column ``machine``, and why a variant is not in it, one sentence each.

    Args:
        model: with its trained weights.
        files: test files, of one size of frames.
        jitters: the sequence ``(N, 2)`` of the data, for a method that reads it.
        every_clip: False takes the first clip of every scene.

    Raises:
        UserError: files of several sizes.
    """
    setting = _size(files, model.scale)
    players: dict[Variant, Player] = {}
    whys: dict[Variant, str] = {}
    for backend, precision in wanted:
        variant = backend.name, precision
        if why := backend.missing(torch.device("cpu"), precision):
            whys[variant] = why
            continue
        try:
            players[variant] = backend.load(
                copy.deepcopy(model), Setting(*setting, precision, torch.device("cpu"), threads, jitters)
            )
        except (
            UserError,
            RuntimeError,
        ) as error:  # a stage that cannot be exported, a type that an operation lacks
            whys[variant] = (str(error).splitlines() or [type(error).__name__])[0][:300]
    clips = whole_clips(list(files), model.requires, 0)
    rows = roll(model, players, clips, prepare, None if every_clip else first_clips(clips))
    return rows.assign(machine=machine()), whys


def _size(files: Sequence[Path], scale: int) -> tuple[int, int]:
    """The low-resolution width and height of all frames."""
    sizes = dict(_sizes(files, scale))
    if len(set(sizes.values())) != 1:
        said = ", ".join(f"{path.name} {width}x{height}" for path, (width, height) in sizes.items())
        raise UserError(f"The test files are of several sizes ({said}): name files of one.")
    return next(iter(sizes.values()))


def _sizes(files: Sequence[Path], scale: int) -> Iterator[tuple[Path, tuple[int, int]]]:
    for path in files:
        width, height = read_spec(path).target_size
        yield path, (width // scale, height // scale)
