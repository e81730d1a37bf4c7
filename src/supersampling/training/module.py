"""The one training loop: any upsampler as a recurrent step, unrolled over a clip, with backpropagation through time."""

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import lightning as L
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from torch import Tensor, nn
from torch.optim import Optimizer
from torch.optim.lr_scheduler import LRScheduler

from supersampling.frames import Frame, clip_length
from supersampling.losses import Loss
from supersampling.metrics.image import psnr
from supersampling.models.base import Upsampler

# Losses of so many steps are checked together: reading a value makes an accelerator wait.
CHECKED_TOGETHER = 16

OptimizerFactory = Callable[[Iterable[nn.Parameter]], Optimizer]
SchedulerFactory = Callable[[Optimizer], LRScheduler]

ADVICE = (
    "The previous checkpoint was kept. A smaller budget.lr, trainer.gradient_clip_val=1 or "
    "trainer.precision=32-true may help."
)


def checkpoints(folder: Path) -> ModelCheckpoint:
    """Return a callback that overwrites ``folder/last.ckpt`` at the end of every epoch, validated or not.

    ``save_last`` without ``save_top_k`` would not do: Lightning then writes one checkpoint, when the training ends.
    """
    return ModelCheckpoint(
        folder, "last", save_top_k=1, every_n_epochs=1, save_on_train_epoch_end=True, enable_version_counter=False
    )


class NotFinite(Exception):
    """A loss became NaN or infinite; the message names the term, the step and the samples."""


def unroll(model: Upsampler, clip: Mapping[str, Tensor], keep: int) -> Tensor:
    """Run a model over a clip from its first frame; return the outputs of the last ``keep`` frames, ``(B, keep, 3, H,
    W)``.

    For the earlier frames, only the state is computed.
    """
    length = clip_length(clip)
    state, outputs = None, []
    for t in range(length):
        frame = Frame.from_clip(clip, t)
        if t < length - keep:
            state = model.advance(frame, state)
        else:
            output, state = model(frame, state)
            outputs.append(output)
    return torch.stack(outputs, dim=1)


class Training(L.LightningModule):
    """Trains ``model`` with ``loss`` on the last ``counted`` frames of each sub-sequence (DLCTUS 4.3.1 and 4.3.4).

    Logs ``train/loss`` per epoch, ``train/<term>`` for each term of a sum of several, and ``val/psnr``, the mean over
    whole validation clips. A loss that is not finite raises `NotFinite` within `CHECKED_TOGETHER` steps, and before any
    checkpoint is written.
    """

    def __init__(
        self, model: Upsampler, loss: Loss, optimizer: OptimizerFactory, scheduler: SchedulerFactory, counted: int
    ) -> None:
        super().__init__()
        self.model = model
        self.loss = loss
        self._make_optimizer = optimizer
        self._make_scheduler = scheduler
        self._outputs = counted + loss.previous
        self._unchecked: list[tuple[int, int, dict[str, Tensor]]] = []  # step, batch of the epoch, terms

    def training_step(self, clip: dict[str, Tensor], batch_index: int) -> Tensor:
        outputs = unroll(self.model, clip, self._outputs)
        frames = {name: values[:, -self._outputs :] for name, values in clip.items()}
        terms = self.loss.terms(outputs, self.model.reference(frames), frames)
        value = torch.stack(list(terms.values())).sum()
        self._unchecked.append((self.global_step, batch_index, {k: v.detach() for k, v in terms.items()}))
        if len(self._unchecked) == CHECKED_TOGETHER:
            self._check()
        mean: Any = {"on_step": False, "on_epoch": True, "batch_size": len(outputs), "sync_dist": True}
        self.log("train/loss", value, **mean)
        if len(terms) > 1:
            self.log_dict({f"train/{name}": term for name, term in terms.items()}, **mean)
        return value

    def on_train_epoch_end(self) -> None:
        self._check()

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Raise `NotFinite` for weights or a loss that are not finite, so that the previous checkpoint stays."""
        self._check()
        bad = [name for name, weight in checkpoint["state_dict"].items() if not weight.isfinite().all()]
        if bad:
            raise NotFinite(
                f"The weights {', '.join(bad[:3])} stopped being finite in the last step of epoch "
                f"{self.current_epoch}, whose "
                f"loss was finite. {ADVICE}"
            )

    def _check(self) -> None:
        """Raise `NotFinite` for the first step since the last check whose terms are not all finite.

        All devices raise it together, for the mean of their terms: that of the whole batch.
        """
        steps, self._unchecked = self._unchecked, []
        if not steps:
            return
        local = torch.stack([v for _, _, terms in steps for v in terms.values()])
        gathered: Any = self.all_gather(local)
        values = gathered.view(-1, len(steps), len(steps[0][2]))  # devices, steps, terms
        if values.isfinite().all():
            return
        for (step, batch, terms), means in zip(steps, values.cpu().double().mean(dim=0).tolist()):
            bad = [f"{name} = {value}" for name, value in zip(terms, means) if not math.isfinite(value)]
            if bad:
                good = [f"{name} = {value:.4g}" for name, value in zip(terms, means) if math.isfinite(value)]
                raise NotFinite(
                    f"The loss stopped being finite at step {step} (epoch {self.current_epoch}, batch {batch}): "
                    f"{', '.join(bad)}{', with ' if good else ''}{', '.join(good)}. Its windows: "
                    f"{'; '.join(self._windows(batch))}. {ADVICE}"
                )

    def _windows(self, batch: int) -> list[str]:
        """Return the names of the windows in a batch of this epoch, those of all devices."""
        loader: Any = self.trainer.train_dataloader
        size = loader.batch_size * self.trainer.world_size
        return [loader.dataset.name(k) for k in loader.sampler.all_indices()[batch * size : (batch + 1) * size]]

    def validation_step(self, clip: dict[str, Tensor], batch_index: int) -> None:
        devices = self.trainer.world_size
        loader: Any = self.trainer.val_dataloaders
        repeats = devices > 1 and loader.sampler.repeats(batch_index)
        mean = torch.zeros((), device=self.device) if repeats else self._mean_psnr(clip)
        # A multiple of the devices: Lightning divides the sum of the sizes by them, and rounds down.
        size = 0 if repeats else devices
        self.log("val/psnr", mean, on_epoch=True, batch_size=size, prog_bar=True, sync_dist=True)

    def _mean_psnr(self, clip: dict[str, Tensor]) -> Tensor:
        targets = clip["target"].shape[1]
        outputs = unroll(self.model, clip, targets)
        first = clip_length(clip) - targets
        images = [self.model.present(outputs[:, k], Frame.from_clip(clip, first + k)) for k in range(targets)]
        return psnr(torch.cat(images).float(), clip["target"].transpose(0, 1).flatten(0, 1)).mean()

    def configure_optimizers(self) -> Any:
        optimizer = self._make_optimizer(self.model.parameters())
        scheduler = self._make_scheduler(optimizer)
        return {"optimizer": optimizer, "lr_scheduler": {"scheduler": scheduler, "interval": "step"}}
