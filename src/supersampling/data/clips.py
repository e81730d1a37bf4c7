"""What training and evaluation read: random windows of random clips, and whole clips in order."""

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

MEMORY_LIMIT = 1 << 30  # bytes of clips that a reading process may keep in memory


@dataclass(frozen=True)
class Cut:
    """The shape of a training sample: ``crop`` target pixels square, ``frames`` long, targets of the last ``targets`` frames."""

    crop: int
    frames: int
    targets: int


class WindowDataset(Dataset[dict[str, Tensor]]):
    """Random windows of random sub-sequences; item ``k`` depends on ``seed`` and ``k`` alone, so that any run can resume.

    Items hold the ``requires`` buffers as ``(T, C, h, w)`` and ``target`` as ``(cut.targets, 3, H, W)``. Files that fit into
    ``memory_limit`` bytes together are kept in memory, larger ones are read window by window.

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
        self._stores: list[DatasetFile] | None = None  # opened in the process that reads
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
                    f"{path} holds {spec.frames} frames, {spec.targets} of them with targets of {size} pixels, too little for "
                    f"budget.frames={cut.frames}, budget.crop={cut.crop} and {cut.targets} targets: lower these, or render "
                    "longer clips or larger windows."
                )

    def __getitem__(self, index: int) -> dict[str, Tensor]:
        if self._stores is None:
            self._stores = self._open()
        rng, place = self._place(index)
        item = {name: self._read(name, place) for name in self._names}
        return {name: torch.from_numpy(values) for name, values in self._augment(item, rng).items()}

    def name(self, index: int) -> str:
        """Which window it is: ``foundry clip 3, frames 1 to 10, at (16, 40)``, from 0, the place in low-resolution pixels."""
        if self._stores is None:
            self._stores = self._open()
        _, place = self._place(index)
        frames = f"frames {place.stop - self._cut.frames} to {place.stop - 1}"
        return f"{self._specs[place.file].scene} clip {place.clip}, {frames}, at ({place.x}, {place.y})"

    def _place(self, index: int) -> tuple[np.random.Generator, ClipWindow]:
        rng = np.random.default_rng((self._seed, index))
        return rng, self._pick(lambda: self._propose(rng), self._motion)

    def _propose(self, rng: np.random.Generator) -> ClipWindow:
        file, clip = self._clips[rng.integers(len(self._clips))]
        spec, cut = self._specs[file], self._cut
        # The last cut.targets frames need targets, which the clip's first frames may lack.
        earliest = max(spec.frames - spec.targets + cut.targets, cut.frames)
        stop = int(rng.integers(earliest, spec.frames + 1))
        width, height = (n // spec.scale for n in spec.target_size)
        side = cut.crop // spec.scale
        x, y = int(rng.integers(width - side + 1)), int(rng.integers(height - side + 1))
        return ClipWindow(file, clip, stop, x, y)

    def _read(self, name: str, place: ClipWindow) -> NDArray[np.float32]:
        scale, cut = self._specs[place.file].scale, self._cut
        side = cut.crop // scale
        window, frames = (place.x, place.y, side, side), cut.frames
        if BUFFERS[name].resolution == "high":
            window, frames = (place.x * scale, place.y * scale, side * scale, side * scale), cut.targets
        assert self._stores is not None
        return self._stores[place.file].read(name, place.clip, slice(place.stop - frames, place.stop), window)

    def _motion(self, place: ClipWindow) -> NDArray[np.float32]:
        return self._read("motion", place).transpose(0, 2, 3, 1) * self._cut.crop

    def _open(self) -> list[DatasetFile]:
        stores = [DatasetFile(path) for path in self._paths]
        if sum(store.size(self._names) for store in stores) <= self._memory_limit:
            for store in stores:
                store.load(self._names)
        return stores


class FreshIndices(Sampler[int]):
    """Indices that no epoch repeats: ``epoch * size ... (epoch + 1) * size - 1``. Lightning calls `set_epoch`."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._epoch = 0

    def set_epoch(self, epoch: int) -> None:
        self._epoch = epoch

    def __len__(self) -> int:
        return self._size

    def __iter__(self) -> Iterator[int]:
        return iter(range(self._epoch * self._size, (self._epoch + 1) * self._size))


@dataclass(frozen=True)
class ClipName:
    """Which clip it is, for tables."""

    scene: str
    clip: int


class WholeClips(Dataset[dict[str, Tensor]]):
    """Every clip of the files, whole and in order: the ``requires`` buffers ``(T, ...)`` and ``target`` of its last frames.

    Val and test files have a target for every frame.
    """

    def __init__(self, paths: Sequence[Path], requires: frozenset[str]) -> None:
        self._stores = [DatasetFile(path) for path in paths]
        self._requires = requires | {"target"}
        self._clips = [(store, c) for store in self._stores for c in range(store.clips)]

    def __len__(self) -> int:
        return len(self._clips)

    @property
    def frames(self) -> int:
        """Of all clips together."""
        return sum(store.spec.frames for store, _ in self._clips)

    def name(self, index: int) -> ClipName:
        store, clip = self._clips[index]
        return ClipName(store.spec.scene, clip)

    def length(self, index: int) -> int:
        """Frames of a clip."""
        return self._clips[index][0].spec.frames

    def read_frames(self, index: int) -> Iterator[dict[str, Tensor]]:
        """A clip as parts of one frame, ``(1, ...)`` each, for files with a target for every frame."""
        store, clip = self._clips[index]
        for t in range(store.spec.frames):
            part = slice(t, t + 1)
            yield {name: torch.from_numpy(store.read(name, clip, part)) for name in sorted(self._requires)}

    def __getitem__(self, index: int) -> dict[str, Tensor]:
        store, clip = self._clips[index]
        first = store.spec.frames - store.spec.targets
        return {
            name: torch.from_numpy(
                store.read(name, clip, slice(first if BUFFERS[name].resolution == "high" else 0, None))
            )
            for name in sorted(self._requires)
        }

    def __iter__(self) -> Iterator[tuple[ClipName, dict[str, Tensor]]]:
        for index in range(len(self)):
            yield self.name(index), self[index]
