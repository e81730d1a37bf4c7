"""Parameters and multiply-accumulates of a method, module by module, from shapes alone."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn
from torch.utils._pytree import tree_map_only
from torch.utils.flop_counter import FlopCounterMode

from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame
from supersampling.models.base import Upsampler

LONGEST = 64  # frames after which a state that still grows is an error


@dataclass(frozen=True)
class Row:
    """A module: its name, class, parameters and multiply-accumulates of one frame."""

    module: str
    kind: str
    parameters: int
    macs: int


def random_frame(model: Upsampler, width: int, height: int, device: str, seed: int = 0) -> Frame:
    """Return a random frame of the buffers that ``model`` reads, ``width x height`` low-resolution pixels, batch 1.

    Values in [0, 1), jitter within its range, motion up to 1 % of the image; on ``device=meta``, shapes without values.
    """
    generator = torch.Generator().manual_seed(seed)
    buffers = {}
    for name in sorted(model.requires):
        buffer = BUFFERS[name]
        scale = model.scale if buffer.resolution == "high" else 1
        size = () if buffer.resolution == "frame" else (height * scale, width * scale)
        shape = (1, buffer.channels, *size)
        if device == "meta":
            buffers[name] = torch.empty(shape, device=device)
            continue
        values = torch.rand(shape, generator=generator)
        if buffer.kind == "plane":
            values = (values - 0.5) * (1.0 if buffer.resolution == "frame" else 0.02)
        buffers[name] = values.to(device)
    return Frame(**buffers)


@torch.no_grad()
def count_modules(model: Upsampler, width: int, height: int, depth: int = 1, device: str = "meta") -> list[Row]:
    """Return rows for the modules down to ``depth`` below the model, for what lies outside of them, and the total.

    Frames are run until the state no longer changes its shapes; the one after that is counted, in evaluation mode.

    Args:
        width, height: of the low-resolution input, at least 1.
        device: ``meta`` computes nothing, and so cannot run methods that look at values.

    Raises:
        UserError: a method looks at values on ``meta``, or its state never stops growing.
    """
    model = model.to(device).eval()
    frame = random_frame(model, width, height, device)
    state: Any = None
    shapes: Any = None
    try:
        for _ in range(LONGEST):
            _, state = model(frame, state)
            before, shapes = shapes, tree_map_only(Tensor, lambda t: tuple(t.shape), state)
            if before == shapes:
                break
        else:
            raise UserError(f"The state of {type(model).__name__} still grows after {LONGEST} frames.")
        with FlopCounterMode(display=False) as counter:
            model(frame, state)
    except (NotImplementedError, RuntimeError) as error:
        if device != "meta":
            raise
        reason = str(error).splitlines()[0]
        raise UserError(
            f"{type(model).__name__} cannot be counted from shapes alone ({reason}): set device=cpu."
        ) from error
    macs = {name: sum(flops.values()) // 2 for name, flops in counter.get_flop_counts().items()}
    return [*_rows(model, type(model).__name__, macs, depth), _row("total", model, macs.get("Global", 0))]


def size_of(model: Upsampler) -> dict[str, float]:
    """Return ``model/parameters`` and ``model/gmac``, by these names.

    ``model/gmac`` is 10^9 multiply-accumulates of a frame with a target of 1920x1080, rounded down to the model's
    scale; it is left out for a method that cannot be counted from shapes only.
    """
    size = {"model/parameters": float(sum(p.numel() for p in model.parameters()))}
    try:
        rows = count_modules(copy.deepcopy(model), 1920 // model.scale, 1080 // model.scale)
    except UserError:
        return size
    return size | {"model/gmac": rows[-1].macs / 1e9}


def _row(name: str, module: nn.Module, macs: int) -> Row:
    return Row(name, type(module).__name__, sum(p.numel() for p in module.parameters()), macs)


def _rows(model: nn.Module, root: str, macs: Mapping[str, int], depth: int) -> list[Row]:
    """Return the children that compute or learn, and a row for what belongs to none of them."""
    rows: list[Row] = []

    def walk(module: nn.Module, path: str, level: int) -> tuple[int, int]:
        """Append the rows below ``module``; return parameters and MACs of its children."""
        parameters = total = 0
        for name, child in module.named_children():
            row = _row(f"{path}.{name}".removeprefix(f"{root}."), child, _macs(child, f"{path}.{name}", macs))
            parameters, total = parameters + row.parameters, total + row.macs
            if not row.parameters and not row.macs:
                continue
            rows.append(row)
            if level < depth:
                walk(child, f"{path}.{name}", level + 1)
        return parameters, total

    parameters, total = walk(model, root, 1)
    rest = sum(p.numel() for p in model.parameters()) - parameters, macs.get("Global", 0) - total
    if any(rest):
        rows.append(Row("(its own)", "", *rest))
    return rows


def _macs(module: nn.Module, path: str, macs: Mapping[str, int]) -> int:
    """Return a module's multiply-accumulates, or its children's if they are called past it."""
    if path in macs:
        return macs[path]
    return sum(_macs(child, f"{path}.{name}", macs) for name, child in module.named_children())
