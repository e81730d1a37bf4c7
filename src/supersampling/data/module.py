"""Sources of data set files (rendered on demand, or named by the user), and the data loaders."""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from pathlib import Path

import lightning as L
from torch import Tensor
from torch.utils.data import DataLoader

from supersampling.data.clips import EqualShares, FreshIndices, Share, WholeClips, WindowDataset
from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError


class DataSource(ABC):
    """Base class of the sources of data set files."""

    @abstractmethod
    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]:
        """Return the files of each split, which have at least the ``buffers``."""


class Files(DataSource):
    """Files that the user names; their scale has to be that of the task.

    ``camera`` is ignored: it is of rendered data, and experiments set it whichever data they are combined with.

    Raises:
        UserError: a split has no file, or a file has a different scale.
    """

    def __init__(
        self, scale: int, train: Sequence[str], val: Sequence[str], test: Sequence[str], camera: str | None = None
    ) -> None:
        self._scale = scale
        self._paths = {"train": list(train), "val": list(val), "test": list(test)}

    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]:
        return {split: self._check(split, buffers) for split in splits}

    def _check(self, split: str, buffers: frozenset[str]) -> list[Path]:
        paths = [Path(p) for p in self._paths[split]]
        if not paths:
            raise UserError(
                f"No {split} file is set: name one or more with data.{split}=[FILE.h5, ...], as data=files requires."
            )
        for path in paths:
            file = DatasetFile(path)
            scale, missing = file.spec.scale, sorted(buffers - file.buffers)
            file.close()
            if scale != self._scale:
                raise UserError(
                    f"{path} was rendered for scale {scale}, but task.scale={self._scale}: set task.scale={scale}, or "
                    "use another file."
                )
            if missing:
                raise UserError(
                    f"{path} has no {missing[0]}, which this configuration reads: render or import it with "
                    f"buffers=[{','.join(missing)}], or select a method and metrics (metrics=capture) that do not read "
                    "it."
                )
        return paths


def fingerprint(paths: Sequence[Path], names: Iterable[str]) -> str:
    """Return one fingerprint of these buffers of several files, independent of the files' order and folders."""
    parts = []
    for path in paths:
        file = DatasetFile(path)
        parts.append(file.fingerprint(sorted(names)))
        file.close()
    return hashlib.sha256("".join(sorted(parts)).encode()).hexdigest()[:16]


class Loaders(L.LightningDataModule):
    """Loaders of training windows and of whole validation clips, for each process its share of them.

    An epoch has ``steps`` batches of ``batch`` windows of all processes together; ``workers`` cannot change a result.
    """

    def __init__(self, train: WindowDataset, val: WholeClips, *, batch: int, steps: int, workers: int) -> None:
        super().__init__()
        self._train, self._val = train, val
        self._batch, self._steps, self._workers = batch, steps, workers
        self._start = (0, 0)

    def continue_at(self, epoch: int, batches: int) -> None:
        """Begin in this epoch, behind its first ``batches`` batches.

        Workers read ahead before Lightning sets a sampler's epoch, so the first loader has to know it.
        """
        self._start = (epoch, batches)

    @property
    def clips(self) -> int:
        """The number of validation clips."""
        return len(self._val)

    def train_dataloader(self) -> DataLoader[dict[str, Tensor]]:
        share = self._share()
        sampler = FreshIndices(self._batch * self._steps, self._batch, share)
        (epoch, batches), self._start = self._start, (0, 0)
        sampler.continue_at(epoch, batches * self._batch)
        return DataLoader(
            self._train,
            batch_size=self._batch // share.processes,
            sampler=sampler,
            num_workers=self._workers,
            persistent_workers=self._workers > 0,
        )

    def val_dataloader(self) -> DataLoader[dict[str, Tensor]]:
        return DataLoader(self._val, batch_size=1, sampler=EqualShares(len(self._val), self._share()), num_workers=0)

    def _share(self) -> Share:
        return Share() if self.trainer is None else Share(self.trainer.global_rank, self.trainer.world_size)
