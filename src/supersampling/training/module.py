"""The one training loop: any upsampler as a recurrent step, unrolled over a clip, with backpropagation through time."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import lightning as L
import torch
from torch import Tensor, nn
from torch.optim import Optimizer
from torch.optim.lr_scheduler import LRScheduler

from supersampling.frames import Frame, length_of
from supersampling.losses import Loss
from supersampling.metrics.image import psnr
from supersampling.models.base import Upsampler

OptimizerFactory = Callable[[Iterable[nn.Parameter]], Optimizer]
SchedulerFactory = Callable[[Optimizer], LRScheduler]


def unroll(model: Upsampler, clip: Mapping[str, Tensor], keep: int) -> Tensor:
    """Run a model over a clip from its first frame; the outputs of the last ``keep`` frames, ``(B, keep, 3, H, W)``."""
    length = length_of(clip)
    state, outputs = None, []
    for t in range(length):
        output, state = model(Frame.of(clip, t), state)
        if t >= length - keep:
            outputs.append(output)
    return torch.stack(outputs, dim=1)


class Training(L.LightningModule):
    """Trains ``model`` with ``loss`` on the last ``counted`` frames of each sub-sequence (DLCTUS 4.3.1 and 4.3.4).

    Logs ``train/loss`` and ``train/lr`` per epoch, and ``val/psnr``, the mean over whole validation clips.
    """

    def __init__(
        self,
        model: Upsampler,
        loss: Loss,
        optimizer: OptimizerFactory,
        scheduler: SchedulerFactory,
        counted: int,
    ) -> None:
        super().__init__()
        self.model = model
        self.loss = loss
        self._make_optimizer = optimizer
        self._make_scheduler = scheduler
        self._kept = counted + loss.previous

    def training_step(self, clip: dict[str, Tensor], batch_index: int) -> Tensor:
        outputs = unroll(self.model, clip, self._kept)
        frames = {name: values[:, -self._kept :] for name, values in clip.items()}
        value = self.loss(outputs, self.model.reference(frames), frames)
        self.log("train/loss", value, on_step=False, on_epoch=True, batch_size=len(outputs))
        return value

    def validation_step(self, clip: dict[str, Tensor], batch_index: int) -> None:
        kept = clip["target"].shape[1]
        outputs = unroll(self.model, clip, kept)
        first = length_of(clip) - kept
        shown = [self.model.present(outputs[:, k], Frame.of(clip, first + k)) for k in range(kept)]
        mean = psnr(torch.cat(shown).float(), clip["target"].transpose(0, 1).flatten(0, 1)).mean()
        self.log("val/psnr", mean, on_epoch=True, batch_size=1, prog_bar=True, sync_dist=True)

    def configure_optimizers(self) -> Any:
        optimizer = self._make_optimizer(self.model.parameters())
        scheduler = self._make_scheduler(optimizer)
        return {"optimizer": optimizer, "lr_scheduler": {"scheduler": scheduler, "interval": "step"}}
