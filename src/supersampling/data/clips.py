"""Datasets of training and evaluation: random windows of random clips, and whole clips in order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import Dataset, Sampler

from supersampling.data.augment import Augment
from supersampling.data.dataset_file import DatasetFile, read_spec
from supersampling.data.pick import ClipWindow, Pick
from supersampling.errors import UserError
from supersampling.frames import BUFFERS

MEMORY_LIMIT = 1 << 30  # bytes of clips that a reading process keeps in memory


@dataclass(frozen=True)
class Cut:
    """The shape of a training sample: ``crop x crop`` target pixels, ``frames`` frames, targets for the last
    ``targets``."""

    crop: int
    frames: int
    targets: int


class WindowDataset(Dataset[dict[str, Tensor]]):
    """Random windows of random sub-sequences; item ``k`` depends on ``seed`` and ``k`` only, so that any run can
    resume.

    Items hold the ``requires`` buffers as ``(T, C, h, w)`` and ``target`` as ``(cut.targets, 3, H, W)``. If all files
    together fit into ``memory_limit`` bytes they are kept in memory, otherwise they are read window by window.

    Raises:
        UserError: the clips are smaller or shorter than the cut.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        cut: Cut,
        requires: frozenset[str],
        pick: Pick,
        augment: Augment,
        seed: int,
        memory_limit: int = MEMORY_LIMIT,
    ) -> None:
        self._paths = [Path(p) for p in paths]
        # Opened in the process that reads.
        self._files: list[DatasetFile] | None = None
        self._cut = cut
        self._names = sorted(requires | {"target"})
        self._pick = pick
        self._augment = augment
        self._seed = seed
        self._memory_limit = memory_limit
        self._specs = [read_spec(path) for path in self._paths]
        self._clips = [(k, c) for k, spec in enumerate(self._specs) for c in range(spec.clips)]
        for path, spec in zip(self._paths, self._specs):
            if min(spec.target_size) < cut.crop or spec.frames < cut.frames or spec.targets < cut.targets:
                size = "x".join(map(str, spec.target_size))
                raise UserError(
                    f"{path} has {spec.frames} frames, {spec.targets} of them with targets of {size} pixels, too few "
                    "for "
                    f"budget.frames={cut.frames}, budget.crop={cut.crop} and {cut.targets} targets: reduce these, or "
                    "render "
                    "longer clips or larger windows."
                )

    def __getitem__(self, index: int) -> dict[str, Tensor]:
        rng, window = self._choose(index)
        item = {name: self._read(name, window) for name in self._names}
        return {name: torch.from_numpy(values) for name, values in self._augment(item, rng).items()}

    def name(self, index: int) -> str:
        """Return a window's name: ``foundry clip 3, frames 1 to 10, at (16, 40)``.

        Numbers count from 0, the position is in low-resolution pixels.
        """
        _, window = self._choose(index)
        frames = f"frames {window.stop - self._cut.frames} to {window.stop - 1}"
        return f"{self._specs[window.file].scene} clip {window.clip}, {frames}, at ({window.x}, {window.y})"

    def _choose(self, index: int) -> tuple[np.random.Generator, ClipWindow]:
        rng = np.random.default_rng((self._seed, index))
        return rng, self._pick(lambda: self._propose(rng), self._motion)

    def _propose(self, rng: np.random.Generator) -> ClipWindow:
        file, clip = self._clips[rng.integers(len(self._clips))]
        spec, cut = self._specs[file], self._cut
        # The last cut.targets frames need targets, which may be missing for the first frames of the clip.
        earliest = max(spec.frames - spec.targets + cut.targets, cut.frames)
        stop = int(rng.integers(earliest, spec.frames + 1))
        width, height = (n // spec.scale for n in spec.target_size)
        side = cut.crop // spec.scale
        x, y = int(rng.integers(width - side + 1)), int(rng.integers(height - side + 1))
        return ClipWindow(file=file, clip=clip, stop=stop, x=x, y=y)

    def _read(self, name: str, window: ClipWindow) -> NDArray[np.float32]:
        scale, cut = self._specs[window.file].scale, self._cut
        side = cut.crop // scale
        region, frames = (window.x, window.y, side, side), cut.frames
        if BUFFERS[name].resolution == "high":
            region, frames = (window.x * scale, window.y * scale, side * scale, side * scale), cut.targets
        return self._open()[window.file].read(name, window.clip, slice(window.stop - frames, window.stop), region)

    def _motion(self, window: ClipWindow) -> NDArray[np.float32]:
        return self._read("motion", window).transpose(0, 2, 3, 1) * self._cut.crop

    def _open(self) -> list[DatasetFile]:
        if self._files is None:
            self._files = [DatasetFile(path) for path in self._paths]
            if sum(file.size(self._names) for file in self._files) <= self._memory_limit:
                for file in self._files:
                    file.load(self._names)
        return self._files


@dataclass(frozen=True)
class Share:
    """The part of the data that one of several processes reads: ``rank`` counts from 0."""

    rank: int = 0
    processes: int = 1


WHOLE = Share()


class FreshIndices(Sampler[int]):
    """Indices without repetition between epochs: ``epoch * size ... (epoch + 1) * size - 1``. Lightning calls
    `set_epoch`, and `continue_at` lets the first pass begin amid an epoch, where a checkpoint was written.

    Of each ``batch`` consecutive indices, a multiple of the processes, a share gets its equal part. So all processes
    together read the same indices in each step, whatever their number.
    """

    def __init__(self, size: int, batch: int = 1, share: Share = WHOLE) -> None:
        self._size = size
        self._part = batch // share.processes
        self._share = share
        self._epoch = 0
        self._done = 0

    def continue_at(self, epoch: int, done: int) -> None:
        """Let the next pass begin in this epoch, behind its first ``done`` indices of all processes together."""
        self._epoch, self._done = epoch, done

    def set_epoch(self, epoch: int) -> None:
        self._epoch = epoch

    def __len__(self) -> int:
        return self._size // self._share.processes

    def __iter__(self) -> Iterator[int]:
        rank, processes = self._share.rank, self._share.processes
        indices, self._done = self.all_indices()[self._done :], 0
        return (k for k in indices if k // self._part % processes == rank)

    def all_indices(self) -> range:
        """Return the epoch's indices of all processes together."""
        return range(self._epoch * self._size, (self._epoch + 1) * self._size)


class EqualShares(Sampler[int]):
    """Every ``processes``-th of ``size`` indices; all shares are of the same length.

    The last indices of some shares repeat others, and `repeats` tells which: processes that read different numbers of
    batches would wait for each other for ever.
    """

    def __init__(self, size: int, share: Share = WHOLE) -> None:
        self._size = size
        self._share = share

    def __len__(self) -> int:
        return -(-self._size // self._share.processes)

    def __iter__(self) -> Iterator[int]:
        return (self._number(k) % self._size for k in range(len(self)))

    def repeats(self, position: int) -> bool:
        """Return whether the index at a position of this share is there only for the length."""
        return self._number(position) >= self._size

    def _number(self, position: int) -> int:
        return position * self._share.processes + self._share.rank


@dataclass(frozen=True)
class ClipName:
    """The name of a clip in tables."""

    scene: str
    clip: int


class WholeClips(Dataset[dict[str, Tensor]]):
    """Every clip of the files, whole and in order: the ``requires`` buffers ``(T, ...)``, and ``target`` for its last
    frames.

    Validation and test files have a target for every frame.
    """

    def __init__(self, paths: Sequence[Path], requires: frozenset[str]) -> None:
        files = [DatasetFile(path) for path in paths]
        self._requires = requires | {"target"}
        self._clips = [(file, c) for file in files for c in range(file.clips)]

    def __len__(self) -> int:
        return len(self._clips)

    @property
    def frames(self) -> int:
        """Return the number of frames of all clips together."""
        return sum(file.spec.frames for file, _ in self._clips)

    def name(self, index: int) -> ClipName:
        file, clip = self._clips[index]
        return ClipName(file.spec.scene, clip)

    def length(self, index: int) -> int:
        """Return the number of frames of a clip."""
        return self._clips[index][0].spec.frames

    def read_frames(self, index: int) -> Iterator[dict[str, Tensor]]:
        """Yield the frames of a clip, ``(1, ...)`` each; the file must have a target for every frame."""
        file, clip = self._clips[index]
        for t in range(file.spec.frames):
            part = slice(t, t + 1)
            yield {name: torch.from_numpy(file.read(name, clip, part)) for name in sorted(self._requires)}

    def __getitem__(self, index: int) -> dict[str, Tensor]:
        file, clip = self._clips[index]
        first = file.spec.frames - file.spec.targets
        return {
            name: torch.from_numpy(
                file.read(name, clip, slice(first if BUFFERS[name].resolution == "high" else 0, None))
            )
            for name in sorted(self._requires)
        }

    def __iter__(self) -> Iterator[tuple[ClipName, dict[str, Tensor]]]:
        for index in range(len(self)):
            yield self.name(index), self[index]
