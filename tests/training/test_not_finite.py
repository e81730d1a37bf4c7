"""A loss or a weight that is not finite stops the run, and the last good checkpoint stays."""

import os
from functools import partial
from typing import ClassVar, NamedTuple

import lightning as L
import pytest
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from lightning.pytorch.plugins.environments import LightningEnvironment
from torch import nn
from torch.utils.data import DataLoader, Dataset

from supersampling.data.clips import FreshIndices, Share
from supersampling.losses import L1, MSE, Loss, Sum
from supersampling.models.base import Upsampler
from supersampling.training.module import CHECKED_TOGETHER, NotFinite, Training, checkpoints
from supersampling.training.processes import ProcessFailure, run_together

BATCH, STEPS = 2, 20


class Gain(Upsampler[None]):
    """One weight times the input: as little as can be trained."""

    requires = frozenset({"color"})

    def __init__(self):
        super().__init__()
        self.scale = 1
        self.gain = nn.Parameter(torch.full((), 0.5))

    def forward(self, frame, state):
        return self.gain * frame.color, None


class Items(Dataset):
    """Items 0, 1, 2 ... of one grey frame; ``seen`` keeps which were read."""

    seen: ClassVar[list[int]] = []

    def __getitem__(self, index):
        Items.seen.append(index)
        image = torch.full((1, 3, 2, 2), 0.5)
        return {"color": image, "target": image}

    def name(self, index):
        return f"item {index}"


class Breaks(Loss):
    """An L1 that is ``value`` from the given call on."""

    requires = frozenset()
    previous = 0

    def __init__(self, at, value):
        super().__init__()
        self.at, self.value, self.calls = at, value, 0

    def forward(self, outputs, targets, frames):
        self.calls += 1
        loss = (outputs - targets).abs().mean()
        return loss * self.value if self.calls > self.at else loss


class BrokenGradient(torch.autograd.Function):
    @staticmethod
    def forward(ctx, x, broken):
        ctx.broken = broken
        return x.clone()

    @staticmethod
    def backward(ctx, gradient):
        return gradient * float("nan") if ctx.broken else gradient, None


class BreaksBackward(Loss):
    """An L1 whose gradient is NaN at one call."""

    requires = frozenset()
    previous = 0

    def __init__(self, at):
        super().__init__()
        self.at, self.calls = at, 0

    def forward(self, outputs, targets, frames):
        self.calls += 1
        return (BrokenGradient.apply(outputs, self.calls == self.at + 1) - targets).abs().mean()


class Run(NamedTuple):
    error: NotFinite
    checkpoint: dict


def training(loss):
    schedule = partial(torch.optim.lr_scheduler.ConstantLR, total_iters=1)
    return Training(Gain(), loss, partial(torch.optim.SGD, lr=1e-3), schedule, 1)


def stopped(folder, loss, validate_every=1, callbacks=None) -> Run:
    """Train until it stops, with a checkpoint of every epoch unless other callbacks are given."""
    Items.seen.clear()
    module = training(loss)
    train = DataLoader(Items(), batch_size=BATCH, sampler=FreshIndices(BATCH * STEPS))
    val = DataLoader(Items(), batch_size=1, sampler=[0])
    trainer = L.Trainer(
        accelerator="cpu", max_epochs=6, logger=False, enable_progress_bar=False, enable_model_summary=False,
        num_sanity_val_steps=0, check_val_every_n_epoch=validate_every,
        callbacks=[checkpoints(folder)] if callbacks is None else callbacks,
        enable_checkpointing=callbacks is None or bool(callbacks),
    )  # fmt: skip
    with pytest.raises(NotFinite) as caught:
        trainer.fit(module, train, val)
    written = sorted(folder.rglob("*.ckpt"))
    return Run(caught.value, torch.load(written[-1], weights_only=True) if written else {})


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize(
    ("step", "validate_every"),
    [(3 * STEPS + 5, 1), (3 * STEPS - 1, 1), (4 * STEPS - 1, 2), (4 * STEPS - 1 - CHECKED_TOGETHER, 2)],
    ids=["amid an epoch", "at its end", "at the end of a validated one", "amid a validated one"],
)
def test_it_stops_and_says_where(tmp_path, step, validate_every, value):
    loss = Sum({"l1": L1, "broken": lambda: Breaks(step, value), "mse": MSE}, {"l1": 1, "broken": 0.5, "mse": 2})
    run = stopped(tmp_path, loss, validate_every)
    said = str(run.error)
    epoch, batch = divmod(step, STEPS)
    assert f"at step {step} (epoch {epoch}, batch {batch}): broken = {value}, with l1 = " in said
    items = list(range(BATCH * step, BATCH * (step + 1)))
    assert f"Its windows: {'; '.join(f'item {k}' for k in items)}. The previous checkpoint" in said
    assert set(items) <= set(Items.seen)
    # The last checkpoint is of a whole epoch before, and good.
    assert run.checkpoint["global_step"] == epoch * STEPS
    assert all(weight.isfinite().all() for weight in run.checkpoint["state_dict"].values())


def test_one_loss_alone_is_named_too(tmp_path):
    run = stopped(tmp_path, Breaks(STEPS + 2, float("nan")))
    assert f"step {STEPS + 2} (epoch 1, batch 2): Breaks = nan. Its windows" in str(run.error)


def test_without_checkpoints_it_stops_at_the_end_of_the_epoch(tmp_path):
    step = STEPS - 1
    run = stopped(tmp_path, Breaks(step, float("nan")), callbacks=[])
    assert f"at step {step} (epoch 0, batch {step})" in str(run.error)


def test_a_checkpoint_amid_an_epoch_is_refused_too(tmp_path):
    often = ModelCheckpoint(tmp_path, "{step}", save_top_k=-1, every_n_train_steps=3)
    run = stopped(tmp_path, Breaks(4, float("nan")), callbacks=[often])
    assert "at step 4 (epoch 0, batch 4)" in str(run.error)
    assert [p.name for p in tmp_path.iterdir()] == ["step=3.ckpt"]


def test_a_gradient_that_breaks_the_weights_in_an_epoch_s_last_step(tmp_path):
    """No loss shows it before the checkpoint would be written."""
    run = stopped(tmp_path, BreaksBackward(3 * STEPS - 1))
    assert "weights model.gain stopped being finite in the last step of epoch 2" in str(run.error)
    assert run.checkpoint["global_step"] == 2 * STEPS
    assert run.checkpoint["state_dict"]["model.gain"].isfinite()


@pytest.mark.parametrize("validate_every", [1, 3])
def test_every_epoch_writes_the_one_checkpoint_and_a_resumed_training_goes_on(tmp_path, validate_every):
    first, moved = tmp_path / "first", tmp_path / "moved"

    def trainer(epochs, folder):
        return L.Trainer(
            accelerator="cpu", max_epochs=epochs, logger=False, enable_progress_bar=False, num_sanity_val_steps=0,
            enable_model_summary=False, check_val_every_n_epoch=validate_every, callbacks=[checkpoints(folder)],
        )  # fmt: skip

    data = (
        DataLoader(Items(), batch_size=BATCH, sampler=FreshIndices(BATCH * STEPS)),
        DataLoader(Items(), batch_size=1, sampler=[0]),
    )
    with pytest.raises(NotFinite):
        trainer(9, first).fit(training(Breaks(2 * STEPS, float("nan"))), *data)
    assert [p.name for p in first.iterdir()] == ["last.ckpt"]
    first.rename(moved)
    Items.seen.clear()
    resumed = trainer(4, moved)
    resumed.fit(training(Breaks(9 * STEPS, 1.0)), *data, ckpt_path=moved / "last.ckpt", weights_only=True)
    assert [p.name for p in moved.iterdir()] == ["last.ckpt"]
    assert torch.load(moved / "last.ckpt", weights_only=True)["global_step"] == resumed.global_step == 4 * STEPS
    assert min(set(Items.seen) - {0}) == 2 * BATCH * STEPS


def train_on_two_devices(step):
    """Train as one of two processes, of which the second meets NaN at a step."""
    share = Share(int(os.environ["LOCAL_RANK"]), 2)
    loss = Breaks(step if share.rank == 1 else 9 * STEPS, float("nan"))
    sampler = FreshIndices(BATCH * STEPS, BATCH, share)
    trainer = L.Trainer(
        accelerator="cpu", devices=2, strategy="ddp", plugins=[LightningEnvironment()], use_distributed_sampler=False,
        max_epochs=2, logger=False, enable_progress_bar=False, enable_model_summary=False, enable_checkpointing=False,
    )  # fmt: skip
    trainer.fit(training(loss), DataLoader(Items(), batch_size=BATCH // 2, sampler=sampler))


@pytest.mark.slow
def test_two_devices_say_what_one_would(tmp_path):
    step = STEPS + 2
    with pytest.raises(ProcessFailure) as caught:
        run_together(train_on_two_devices, [step], 2)
    items = "; ".join(f"item {k}" for k in range(BATCH * step, BATCH * (step + 1)))
    place = f"at step {step} (epoch 1, batch 2): Breaks = nan. Its windows: {items}. The previous"
    assert f"NotFinite: The loss stopped being finite {place}" in str(caught.value)
