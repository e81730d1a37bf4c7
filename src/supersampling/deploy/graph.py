"""A method as ONNX graphs: one for a clip's first frame, one for all later frames, with state inputs and outputs."""

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

OPSET = 20  # the first whose GridSample equals PyTorch's
MULTIPLES = (1, 4, 8)  # a size may have to be a multiple of one of these, tried in this order
LARGEST = 2**14  # pixels per side of the low-resolution input
# Two sizes that are multiples of all MULTIPLES. No axis of fixed length grows from the first to the second.
TRACED = (24, 16), (56, 40)
IMAGE = "image"

Axis = int | tuple[int, str]  # a fixed length, or a multiple of the low resolution's w or h


@dataclass(frozen=True)
class Slot:
    """A tensor that goes from one frame to the next: its name, axes and type."""

    name: str
    axes: tuple[Axis, ...]
    dtype: str

    @property
    def output(self) -> str:
        return f"next_{self.name}"


@dataclass(frozen=True, kw_only=True)
class Graphs:
    """The two exported programs (one and the same if there is no state), with their inputs and state.

    ``first`` runs a clip's first frame, ``next`` all later ones. ``inputs`` are names of buffers. ``size`` is the only
    ``(width, height)`` that the graphs take. If it is None, they take every multiple of ``multiple`` that is at least
    twice as large: PyTorch's export does not leave a length of 1 free.
    """

    first: Any
    next: Any
    inputs: tuple[str, ...]
    state: tuple[Slot, ...]
    size: tuple[int, int] | None
    multiple: int


class _FrameStep(nn.Module):
    """The step of one frame on lists of tensors: returns the presented image, then the tensors of the new state.

    All of these are copies: a state may be an input itself, and the first state may hold the same tensor several times.
    The exporter merges tensors that are the same object while tracing.
    """

    def __init__(self, model: Upsampler, names: Sequence[str], structure: Any) -> None:
        super().__init__()
        self.model, self.names, self.structure = model, list(names), structure

    def forward(self, buffers: list[Tensor], state: list[Tensor]) -> list[Tensor]:
        frame = Frame(**dict(zip(self.names, buffers)))
        before = pytree.tree_unflatten(list(state), self.structure) if state else None
        output, after = self.model(frame, before)
        image = self.model.present(output, frame)
        tensors = [leaf for leaf in pytree.tree_leaves(after) if isinstance(leaf, Tensor)]  # None is a leaf, too
        return [t.clone() for t in (image, *tensors)]


def export(model: Upsampler, size: tuple[int, int] | None) -> Graphs:
    """Return both graphs of ``model`` in evaluation mode, batch 1.

    Args:
        size: width and height of the low-resolution input; None for graphs that take every size that the method allows.

    Raises:
        UserError: a stage cannot be exported, the state does not keep its shape, or only a fixed size is possible.
    """
    model = model.cpu().eval()
    names = tuple(sorted(model.requires))
    traced = size or TRACED[0]
    frame, structure, state = _example(model, traced)
    slots = _slots(state, traced, None if size else _example(model, TRACED[1])[2])
    buffers = [getattr(frame, name) for name in names]
    step = _FrameStep(model, names, structure)
    tensors = [leaf.detach().clone() for _, leaf in state]
    if [t.shape for t in step(buffers, tensors)[1:]] != [t.shape for t in tensors]:
        raise UserError(
            f"{type(model).__name__}'s state grows after its first frame: only a state of constant shape is exported."
        )
    axes = [_buffer_axes(name, model.scale) for name in names], [slot.axes for slot in slots]

    def convert(state_inputs: list[Tensor], multiple: int | None) -> Any:
        shapes = None
        if multiple:
            shapes = tuple([_dynamic(a, multiple) for a in part] for part in axes)
            shapes = shapes if state_inputs else (shapes[0], [])
        return _program(step, (buffers, state_inputs), shapes, names, slots)

    first, multiple = _first_possible(lambda m: convert([], m), (None,) if size else MULTIPLES)
    later = first
    if tensors:
        candidates = (None,) if size else tuple(m for m in MULTIPLES if m >= (multiple or 1))
        later, common = _first_possible(lambda m: convert(tensors, m), candidates)
        if common != multiple:
            first, multiple = convert([], common), common
    return Graphs(first=first, next=later, inputs=names, state=slots, size=size, multiple=multiple or 1)


@torch.no_grad()
def _example(model: Upsampler, size: tuple[int, int]) -> tuple[Frame, Any, list[tuple[str, Tensor]]]:
    """Return a random frame, the structure of the state after it, and the state's tensors with their names."""
    frame = random_frame(model, *size, "cpu")
    try:
        _, state = model(frame, None)
    except (RuntimeError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise UserError(f"This method does not run at size={list(size)} ({reason}): use another size.") from error
    leaves, structure = pytree.tree_flatten_with_path(state)
    tensors = [(_name(pytree.keystr(path)), leaf) for path, leaf in leaves if isinstance(leaf, Tensor)]
    return frame, structure, tensors


def _name(path: str) -> str:
    """Return a name for a path in the state: ``state_inputs_0`` for ``.inputs[0]``."""
    return re.sub(r"\W+", "_", f"state{path}").strip("_")


def _buffer_axes(buffer: str, scale: int) -> tuple[Axis, ...]:
    if BUFFERS[buffer].resolution == "frame":
        return (1, BUFFERS[buffer].channels)
    times = scale if BUFFERS[buffer].resolution == "high" else 1
    return (1, BUFFERS[buffer].channels, (times, "h"), (times, "w"))


def _slots(
    state: list[tuple[str, Tensor]], size: tuple[int, int], larger: list[tuple[str, Tensor]] | None
) -> tuple[Slot, ...]:
    """Return the slots of the state's tensors; axes that grow with the image differ in the ``larger`` image's state."""
    slots = []
    for k, (name, tensor) in enumerate(state):
        larger_shape = tensor.shape if larger is None else larger[k][1].shape
        axes = tuple(_axis(name, a, b, size) for a, b in zip(tensor.shape, larger_shape))
        slots.append(Slot(name, axes, str(tensor.dtype).removeprefix("torch.")))
    return tuple(slots)


def _axis(name: str, length: int, longer: int, size: tuple[int, int]) -> Axis:
    if length == longer:
        return length
    for side, small, large in zip("wh", size, TRACED[1]):
        if length % small == 0 and longer == length // small * large:
            return length // small, side
    raise UserError(
        f"An axis of {name} is neither fixed nor a multiple of the image's width or height: give size=[width,height]."
    )


def _dynamic(axes: tuple[Axis, ...], multiple: int) -> dict[int, Any]:
    """Return the axes that `torch.export` leaves free, each a constant times ``multiple`` times a free number."""
    free = {}
    for k, axis in enumerate(axes):
        if isinstance(axis, tuple):
            times, side = axis
            dim: Any = torch.export.Dim(side, min=1, max=LARGEST // multiple)
            free[k] = dim if times * multiple == 1 else times * multiple * dim
    return free


def _first_possible(convert: Callable[[int | None], Any], multiples: Sequence[int | None]) -> tuple[Any, int | None]:
    """Return a conversion's result with the first of the multiples that it is valid for."""
    for multiple in multiples:
        try:
            return convert(multiple), multiple
        except torch._dynamo.exc.UserError as error:  # the step branches on the size
            reason = error
    raise UserError(
        f"One graph for all sizes is not possible here ({str(reason).splitlines()[0]}): give size=[width,height] of "
        "the low-resolution input."
    )


def _program(
    step: nn.Module, arguments: tuple[Any, ...], shapes: Any, names: Sequence[str], slots: Sequence[Slot]
) -> Any:
    """Return the ONNX program of a step.

    Call `torch.export` here instead of leaving it to `torch.onnx.export`: if a branch on the size forbids an export,
    that one falls back to less strict ways without a warning, and its graph is wrong at other sizes.
    """
    state_names = [slot.name for slot in slots] if arguments[1] else []
    try:
        exported = torch.export.export(step, arguments, dynamic_shapes=shapes, strict=False)
        program: Any = torch.onnx.export(
            exported,
            dynamo=True,
            verbose=False,
            opset_version=OPSET,
            input_names=[*names, *state_names],
            output_names=[IMAGE, *(slot.output for slot in slots)],
        )
    except torch._dynamo.exc.UserError:
        raise
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise UserError(
            f"This method cannot be exported ({reason}): choose stages that compute with tensors only, for example "
            "model/flow=motion_vectors in place of tvl1, which runs outside of PyTorch."
        ) from error
    for node in program.model.graph:
        node.metadata_props.clear()  # the exporter writes the source files' paths there
    return program
