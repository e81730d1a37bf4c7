"""Runner of an exported method, frame by frame, outside of PyTorch."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.deploy.runtimes import Runtime
from supersampling.errors import UserError, describe_system_error


def sidecar(path: Path) -> Path:
    """Return the path of the description of an exported ``FILE.onnx``: ``FILE.json``."""
    return path.with_suffix(".json")


def digest(path: Path) -> str:
    """Return 64 hex digits of a file's content: ONNX has no checksum, so that damage could change weights unseen."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class Runner:
    """An exported method: ``runner(buffers) -> image`` computes the next frame and carries the state.

    ``buffers`` are float32 arrays by name, as in `Frame`, batch 1; buffers that the method does not read are ignored.
    The image is ``(1, 3, H, W)``, display-referred in [0, 1].

    Raises:
        UserError: the file, its description or a buffer is missing, the file is not as it was written, or the graph
            does not take a size.
    """

    def __init__(self, path: Path, runtime: Runtime) -> None:
        try:
            self.description: dict[str, Any] = json.loads(sidecar(path).read_text())
            graphs = {role: path.parent / name for role, name in self.description["graphs"].items()}
            digests = dict(self.description.get("digests", {}))
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            condition = describe_system_error(error, sidecar(path)) if isinstance(error, OSError) else None
            raise condition or UserError(
                f"The description {sidecar(path)} of {path} is missing or broken: write both again with export.py."
            ) from error
        for graph in {*graphs.values(), *(path.parent / name for name in digests)}:
            if not graph.is_file():
                raise UserError(f"Graph file {graph} not found: keep the files that export.py writes in one folder.")
            if digests.get(graph.name) not in (None, digest(graph)):
                raise UserError(
                    f"Graph file {graph} is not as export.py wrote it: write it again, or remove digests from "
                    f"{sidecar(path)} if you changed the graph yourself."
                )
        loaded = {graph: runtime.load(graph) for graph in set(graphs.values())}
        self._first, self._next = loaded[graphs["first"]], loaded[graphs["next"]]
        self._inputs: list[str] = [i["name"] for i in self.description["inputs"]]
        self._slots = [(s["input"], s["output"]) for s in self.description["state"]]
        self.reset()

    def reset(self) -> None:
        """Forget the state: call this at a clip's start, after a cut, or when the size changes."""
        self._state: dict[str, NDArray[Any]] | None = None

    @property
    def state(self) -> Mapping[str, NDArray[Any]]:
        """The tensors of the state by name; empty before the first frame."""
        return dict(self._state or {})

    def __call__(self, buffers: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        missing = [name for name in self._inputs if name not in buffers]
        if missing:
            raise UserError(f"Buffer {missing[0]} is missing: this method reads {', '.join(self._inputs)}.")
        values = {name: np.ascontiguousarray(buffers[name]) for name in self._inputs}
        values.update(self._state or {})
        self._check(values)
        results = self._first(values) if self._state is None else self._next(values)
        self._state = {name: results[output] for name, output in self._slots}
        return results[self.description["output"]["name"]]

    def _check(self, values: Mapping[str, NDArray[Any]]) -> None:
        """Compare the values with the described shapes; the first values bind the symbols ``h`` and ``w``."""
        limits, sides = self.description["size"], dict[str, int]()
        tensors = [(t["name"], t["shape"]) for t in self.description["inputs"]]
        tensors += [(s["input"], s["shape"]) for s in self.description["state"]]
        for name, shape in tensors:
            if name not in values:  # the state on the first frame
                continue
            actual = values[name].shape
            if len(actual) != len(shape) or not all(_fits(n, axis, sides) for n, axis in zip(actual, shape)):
                raise UserError(
                    f"Invalid shape {list(actual)} of {name}, this graph takes {shape}{_bindings(sides)}: export with "
                    "size=[width,height] for another size, and call reset() after a change of size."
                )
        if any(n % limits["multiple_of"] or n < limits["at_least"] for n in sides.values()):
            raise UserError(
                f"Invalid size {sides['w']}x{sides['h']}, this graph takes multiples of {limits['multiple_of']}, at "
                f"least {limits['at_least']}: pad the frames, or export with size=[{sides['w']},{sides['h']}]."
            )


def _fits(length: int, axis: int | str, sides: dict[str, int]) -> bool:
    """Return whether a length agrees with the description of its axis: a number, ``h``, or ``4*h``."""
    if isinstance(axis, int):
        return length == axis
    times, _, side = axis.rpartition("*")
    whole = int(times or 1)
    return length % whole == 0 and sides.setdefault(side, length // whole) == length // whole


def _bindings(sides: Mapping[str, int]) -> str:
    return " with " + ", ".join(f"{side} = {n}" for side, n in sides.items()) if sides else ""
