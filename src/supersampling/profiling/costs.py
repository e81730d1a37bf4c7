"""Effect of each backend and precision on the quality of one method's weights, as a table to log beside its times."""

import copy
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor

from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError, first_line
from supersampling.evaluation.score import whole_clips
from supersampling.metrics.prepare import Prepare
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, LoadOptions
from supersampling.profiling.drift import Player, Variant, first_clips, roll
from supersampling.runs.experiment import machine

LONGEST_REASON = 300  # characters


def measure(
    model: Upsampler,
    combinations: Sequence[tuple[Backend, str]],
    files: Sequence[Path],
    prepare: Prepare,
    jitters: Tensor | None,
    threads: int,
    all_clips: bool = False,
) -> tuple[pd.DataFrame, dict[Variant, str]]:
    """Return the table of `roll` with the column ``machine``, and for each missing variant a reason of one sentence.

    Args:
        model: the method with its trained weights.
        combinations: backends, each with a precision.
        files: test files with frames of equal size.
        jitters: the sequence ``(N, 2)`` of the data, for a method that reads it.
        all_clips: False takes the first clip of each scene.

    Raises:
        UserError: the files have frames of several sizes.
    """
    width, height = _low_resolution(files, model.scale)
    device = torch.device("cpu")
    players: dict[Variant, Player] = {}
    reasons: dict[Variant, str] = {}
    for backend, precision in combinations:
        variant = backend.name, precision
        if reason := backend.missing(device, precision):
            reasons[variant] = reason
            continue
        options = LoadOptions(
            width=width, height=height, precision=precision, device=device, threads=threads, jitters=jitters
        )
        try:
            players[variant] = backend.load(copy.deepcopy(model), options)
        # A stage that cannot be exported, or a type that an operation does not support.
        except (UserError, RuntimeError) as error:
            reasons[variant] = first_line(error)[:LONGEST_REASON]
    clips = whole_clips(list(files), model.requires, 0)
    rows = roll(model, players, clips, prepare, None if all_clips else first_clips(clips))
    return rows.assign(machine=machine()), reasons


def _low_resolution(files: Sequence[Path], scale: int) -> tuple[int, int]:
    """Return the low-resolution width and height of all frames."""
    targets = {path: read_spec(path).target_size for path in files}
    sizes = {path: (width // scale, height // scale) for path, (width, height) in targets.items()}
    if len(set(sizes.values())) != 1:
        summary = ", ".join(f"{path.name} {width}x{height}" for path, (width, height) in sizes.items())
        raise UserError(f"The test files have frames of several sizes ({summary}): use files of one size.")
    return next(iter(sizes.values()))
