"""Where clips come from (rendered on demand, or the user's own files) and the loaders over them."""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from pathlib import Path

import lightning as L
from torch import Tensor
from torch.utils.data import DataLoader

from supersampling.data.clips import FreshIndices, WholeClips, WindowDataset
from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError


class DataSource(ABC):
    """Gives the data set files of each split, with at least the ``buffers`` that are asked for."""

    @abstractmethod
    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]: ...


class Files(DataSource):
    """Files that the user names; their scale has to be the task's.

    Raises:
        UserError: no file for a split, or one of another scale.
    """

    def __init__(self, scale: int, train: Sequence[str], val: Sequence[str], test: Sequence[str]) -> None:
        self._scale = scale
        self._paths = {"train": list(train), "val": list(val), "test": list(test)}

    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]:
        return {split: self._checked(split, buffers) for split in splits}

    def _checked(self, split: str, buffers: frozenset[str]) -> list[Path]:
        paths = [Path(p) for p in self._paths[split]]
        if not paths:
            raise UserError(f"data=files needs data.{split}=[FILE.h5, ...]: no {split} file was named.")
        for path in paths:
            store = DatasetFile(path)
            scale, missing = store.spec.scale, sorted(buffers - store.buffers)
            store.close()
            if scale != self._scale:
                raise UserError(
                    f"{path} was rendered for scale {scale}, but task.scale={self._scale}: set task.scale={scale} or "
                    "name another file."
                )
            if missing:
                raise UserError(
                    f"{path} has no {missing[0]}, which this configuration reads: render or import it with "
                    f"buffers=[{','.join(missing)}], or choose a method and metrics (metrics=capture) that do without."
                )
        return paths


def fingerprint(paths: Sequence[Path], names: Iterable[str]) -> str:
    """One fingerprint of these buffers of several files, independent of their order and place."""
    parts = []
    for path in paths:
        store = DatasetFile(path)
        parts.append(store.fingerprint(sorted(names)))
        store.close()
    return hashlib.sha256("".join(sorted(parts)).encode()).hexdigest()[:16]


class Loaders(L.LightningDataModule):
    """Training windows and whole validation clips. ``batch`` and ``steps`` an epoch; ``workers`` cannot change a result."""

    def __init__(self, train: WindowDataset, val: WholeClips, *, batch: int, steps: int, workers: int) -> None:
        super().__init__()
        self._train, self._val = train, val
        self._batch, self._steps, self._workers = batch, steps, workers

    def train_dataloader(self) -> DataLoader[dict[str, Tensor]]:
        return DataLoader(
            self._train,
            batch_size=self._batch,
            sampler=FreshIndices(self._batch * self._steps),
            num_workers=self._workers,
            persistent_workers=self._workers > 0,
        )

    def val_dataloader(self) -> DataLoader[dict[str, Tensor]]:
        return DataLoader(self._val, batch_size=1, num_workers=0)
