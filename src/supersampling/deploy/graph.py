"""A method as ONNX graphs: one for a clip's first frame, one for every other, the state as inputs and outputs."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn
from torch.utils import _pytree as pytree

from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame
from supersampling.models.base import Upsampler
from supersampling.models.count import random_frame

OPSET = 20  # the first whose GridSample is the one of PyTorch
MULTIPLES = (1, 4, 8)  # of which a size may have to be one, tried in this order
LARGEST = 2**14  # pixels a side, of the low-resolution input
TRACED = (24, 16), (56, 40)  # two sizes that are multiples of all MULTIPLES and of no axis that is no image's
IMAGE = "image"

Axis = int | tuple[int, str]  # a fixed length, or so many times the low resolution's w or h


@dataclass(frozen=True)
class Slot:
    """A tensor that goes from one frame to the next: its name, its axes, its type."""

    name: str
    axes: tuple[Axis, ...]
    dtype: str

    @property
    def output(self) -> str:
        return f"next_{self.name}"


@dataclass(frozen=True)
class Graphs:
    """The two exported programs (one and the same where there is no state), and what goes in and out.

    ``inputs`` are buffers by name. ``size`` is the one ``(width, height)`` that they take, or None, where any multiple of
    ``multiple`` from twice it up is taken: PyTorch's export does not keep a length of 1 free.
    """

    first: Any
    other: Any
    inputs: tuple[str, ...]
    state: tuple[Slot, ...]
    size: tuple[int, int] | None
    multiple: int


class _Step(nn.Module):
    """A frame's step on lists of tensors: what is presented, then the new state's tensors.

    All of these are copies: a state may be an input itself, and a first state one tensor several times, which an exporter
    would take for one ever after.
    """

    def __init__(self, model: Upsampler, names: Sequence[str], structure: Any) -> None:
        super().__init__()
        self.model, self.names, self.structure = model, list(names), structure

    def forward(self, buffers: list[Tensor], state: list[Tensor]) -> list[Tensor]:
        frame = Frame(**dict(zip(self.names, buffers)))
        before = pytree.tree_unflatten(list(state), self.structure) if state else None
        output, after = self.model(frame, before)
        shown = self.model.present(output, frame)
        held = [leaf for leaf in pytree.tree_leaves(after) if isinstance(leaf, Tensor)]  # None has a leaf, None
        return [t.clone() for t in (shown, *held)]


def export(model: Upsampler, size: tuple[int, int] | None) -> Graphs:
    """Both graphs of ``model``, in evaluation mode, batch 1.

    Args:
        size: width and height of the low-resolution input, or None for graphs that take any that the method allows.

    Raises:
        UserError: a stage cannot be exported, the state does not keep its shape, or nothing but a fixed size will do.
    """
    model = model.cpu().eval()
    names = tuple(sorted(model.requires))
    traced = size or TRACED[0]
    frame, structure, state = _example(model, traced)
    slots = _slots(state, traced, None if size else _example(model, TRACED[1])[2])
    buffers = [getattr(frame, name) for name in names]
    step = _Step(model, names, structure)
    held = [leaf.detach().clone() for _, leaf in state]
    if [t.shape for t in step(buffers, held)[1:]] != [t.shape for t in held]:
        raise UserError(f"{type(model).__name__}'s state grows after its first frame, so it is not exported.")
    axes = [_axes_of(name, model.scale) for name in names], [slot.axes for slot in slots]

    def convert(with_state: list[Tensor], multiple: int | None) -> Any:
        shapes = None
        if multiple:
            shapes = tuple([_dynamic(a, multiple) for a in part] for part in axes)
            shapes = shapes if with_state else (shapes[0], [])
        return _program(step, (buffers, with_state), shapes, names, slots)

    first, multiple = _sizes(lambda m: convert([], m), (None,) if size else MULTIPLES)
    other = first
    if held:
        other, needed = _sizes(lambda m: convert(held, m), (None,) if size else _from(multiple))
        if needed != multiple:
            first, multiple = convert([], needed), needed
    return Graphs(first, other, names, slots, size, multiple or 1)


def _from(multiple: int | None) -> tuple[int, ...]:
    return tuple(m for m in MULTIPLES if m >= (multiple or 1))


@torch.no_grad()
def _example(model: Upsampler, size: tuple[int, int]) -> tuple[Frame, Any, list[tuple[str, Tensor]]]:
    """A frame, the structure of the state after it, and its tensors by their path."""
    frame = random_frame(model, *size, "cpu")
    try:
        _, state = model(frame, None)
    except (RuntimeError, ValueError) as error:
        raise UserError(f"size={list(size)} is not possible: {str(error).splitlines()[0]}.") from error
    leaves, structure = pytree.tree_flatten_with_path(state)
    return (
        frame,
        structure,
        [(_name(pytree.keystr(path)), leaf) for path, leaf in leaves if isinstance(leaf, Tensor)],
    )


def _name(path: str) -> str:
    """``state_inputs_0`` of ``.inputs[0]``."""
    return re.sub(r"\W+", "_", f"state{path}").strip("_")


def _axes_of(buffer: str, scale: int) -> tuple[Axis, ...]:
    if BUFFERS[buffer].resolution == "frame":
        return (1, BUFFERS[buffer].channels)
    times = scale if BUFFERS[buffer].resolution == "high" else 1
    return (1, BUFFERS[buffer].channels, (times, "h"), (times, "w"))


def _slots(
    state: list[tuple[str, Tensor]], size: tuple[int, int], larger: list[tuple[str, Tensor]] | None
) -> tuple[Slot, ...]:
    """The state's tensors; which of their axes grow with the image shows in a ``larger`` one's."""
    slots = []
    for k, (name, tensor) in enumerate(state):
        other = tensor.shape if larger is None else larger[k][1].shape
        axes = tuple(_axis(name, a, b, size) for a, b in zip(tensor.shape, other))
        slots.append(Slot(name, axes, str(tensor.dtype).removeprefix("torch.")))
    return tuple(slots)


def _axis(name: str, length: int, longer: int, size: tuple[int, int]) -> Axis:
    if length == longer:
        return length
    for side, small, large in zip("wh", size, TRACED[1]):
        if length % small == 0 and longer == length // small * large:
            return length // small, side
    raise UserError(f"{name} is neither of the image's size nor of a fixed one: give size=[width,height].")


def _dynamic(axes: tuple[Axis, ...], multiple: int) -> dict[int, Any]:
    """The axes that `torch.export` keeps free: times ``multiple`` times a free number."""
    free = {}
    for k, axis in enumerate(axes):
        if isinstance(axis, tuple):
            times, side = axis
            dim: Any = torch.export.Dim(side, min=1, max=LARGEST // multiple)
            free[k] = dim if times * multiple == 1 else times * multiple * dim
    return free


def _sizes(convert: Callable[[int | None], Any], multiples: Sequence[int | None]) -> tuple[Any, int | None]:
    """The first of the multiples that a conversion holds for."""
    for multiple in multiples:
        try:
            return convert(multiple), multiple
        except torch._dynamo.exc.UserError as error:  # the step branches on the size
            reason = error
    raise UserError(
        f"One graph for all sizes is not possible here ({str(reason).splitlines()[0]}): give size=[width,height] of the "
        "low-resolution input."
    )


def _program(
    step: nn.Module, arguments: tuple[Any, ...], shapes: Any, names: Sequence[str], slots: Sequence[Slot]
) -> Any:
    """The ONNX program of a step.

    `torch.export` is called here and not left to `torch.onnx.export`, which goes on with less strict ways when a branch on
    the size forbids an export: its graph then is wrong at other sizes, and says nothing.
    """
    held = [slot.name for slot in slots] if arguments[1] else []
    try:
        exported = torch.export.export(step, arguments, dynamic_shapes=shapes, strict=False)
        program = torch.onnx.export(
            exported,
            dynamo=True,
            verbose=False,
            opset_version=OPSET,
            input_names=[*names, *held],
            output_names=[IMAGE, *(slot.output for slot in slots)],
        )
    except torch._dynamo.exc.UserError:
        raise
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise UserError(
            f"This method cannot be exported ({reason}): choose stages that work on tensors alone, for example "
            "model/flow=motion_vectors in place of tvl1, which runs outside of PyTorch."
        ) from error
    assert program is not None
    for node in program.model.graph:
        node.metadata_props.clear()  # the exporter writes the source files' paths there
    return program
