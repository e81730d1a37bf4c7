"""The losses of ten training steps of every model, at full precision, as they were when ``golden_losses.json`` was
written.

    python tests/training/test_golden_losses.py     writes the file anew; only a change that is meant to change results
    may

All is in float64, so that the numbers hold on any machine, and goes through the loop of ``train.py``. Those of DLCTUS
with the published clamp are computed once more from the thesis alone.
"""

import json
import os
import runpy
import warnings
from pathlib import Path
from types import SimpleNamespace

import lightning as L
import pytest
import torch
import torch.nn.functional as F
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from torch.utils.data import DataLoader

from supersampling.training.module import Training

ROOT = Path(__file__).parents[2]
NUMBERS = Path(__file__).with_name("golden_losses.json")
STEPS, FRAMES, BATCH = 10, 4, 2
SCALE, LOW = 4, (5, 6)  # rows and columns of the low resolution
COUNTED = 2  # frames that the loss sees, the last ones
CASES = {
    "dlctus": ["model=dlctus", "loss=spatiotemporal", "loss.theta=0.1"],
    "dlctus_clamp": ["model=dlctus", "model/confine=clamp", "loss=spatiotemporal", "loss.theta=0.1"],
    "nsrr": ["model=nsrr", "model.previous=2", "loss=sum", "loss.weights.l1=1", "loss.weights.ssim=1"],
    "nsrd": ["model=nsrd", "loss=nsrd"],
    "enss_s": ["model=enss_s", "model.kernel_prediction.width=16", "loss=l1"],
}


def wave(x, y, t, k):
    """Smooth, in [0.1, 0.9], and another one for every whole ``k``; ``x y`` in units of the image."""
    first = torch.sin((5.0 + 0.7 * k) * x + (3.0 - 0.4 * k) * y + 1.3 * k + 0.05 * t)
    second = torch.cos((2.0 - 0.5 * k) * x - (4.0 + 0.3 * k) * y + 0.7 * k)
    return 0.5 + 0.2 * first + 0.2 * second


def waves(position, t, first, count):
    return torch.stack([wave(*position, t, k) for k in range(first, first + count)], dim=1)


def frame(t):
    """All buffers ``(B, C, ...)`` of time ``t``: a surface of many waves that slides, each item of the batch in its
    direction."""
    h, w = LOW
    velocity = torch.tensor([[0.031, -0.017], [-0.023, 0.037]], dtype=torch.float64)  # image units a frame
    jitter = torch.tensor([[0.11 - 0.17 * t, 0.19 * t - 0.31], [0.23 * t - 0.37, 0.41 - 0.13 * t]], dtype=torch.float64)

    def surface(rows, columns, offset):
        y, x = torch.meshgrid(*(torch.arange(n, dtype=torch.float64) + 0.5 for n in (rows, columns)), indexing="ij")
        x = (x + offset[:, 0, None, None]) / columns - t * velocity[:, 0, None, None]
        y = (y + offset[:, 1, None, None]) / rows - t * velocity[:, 1, None, None]
        return x, y

    sample = surface(h, w, jitter)
    fine = surface(h * SCALE, w * SCALE, torch.zeros_like(jitter))
    motion = -velocity[:, :, None, None] + 0.01 * (waves(sample, t, 20, 2) - 0.5)
    light, material, emission = (0, 3), (6, 3), (9, 3)
    buffers = {"jitter": jitter, "motion": motion, "motion_dual": motion + 0.04 * waves(sample, t, 22, 2) - 0.02}
    buffers["depth"] = waves(sample, t, 12, 1)
    buffers["normal"] = F.normalize(waves(sample, t, 13, 3) - 0.4, dim=1)
    buffers["color"] = waves(sample, t, *light)
    buffers["target"] = waves(fine, t, *light)
    for position, prefix, radiance in ((sample, "", "radiance"), (fine, "high_", "target_radiance")):
        buffers[f"{prefix}material"] = waves(position, t, *material)
        buffers[f"{prefix}emission"] = 0.1 * waves(position, t, *emission)
        lit = 2.0 * waves(position, t, *light) * buffers[f"{prefix}material"]
        buffers[radiance] = lit + buffers[f"{prefix}emission"]
    return buffers


def clip():
    frames = [frame(t) for t in range(FRAMES)]
    return {name: torch.stack([f[name] for f in frames], dim=1) for name in frames[0]}


class Losses(L.Callback):
    def __init__(self):
        self.values = []

    def on_train_batch_end(self, trainer, module, outputs, batch, index):
        self.values.append(outputs["loss"].item())


def make(name):
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        cfg = compose("train", [*CASES[name], "budget=paper", f"task.scale={SCALE}"])
    torch.manual_seed(0)
    default = torch.get_default_dtype()
    torch.set_default_dtype(
        torch.float64
    )  # initial weights, too: in float32 they differ by a rounding between processors
    try:
        return cfg, instantiate(cfg.model)
    finally:
        torch.set_default_dtype(default)


def losses_of(name):
    """Ten steps on one batch by the loop of ``train.py``."""
    cfg, model = make(name)
    module = Training(
        model, instantiate(cfg.loss), instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), COUNTED
    )
    losses = Losses()
    trainer = L.Trainer(
        max_steps=STEPS, precision="64-true", accelerator="cpu", logger=False, enable_checkpointing=False,
        enable_progress_bar=False, enable_model_summary=False, callbacks=[losses], limit_val_batches=0,
    )  # fmt: skip
    wanted = model.requires | model.compares | module.loss.requires
    batch = {buffer: values for buffer, values in clip().items() if buffer in wanted}
    assert batch.keys() == wanted
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        trainer.fit(module, train_dataloaders=DataLoader([batch] * STEPS, batch_size=None))
    return losses.values


@pytest.fixture(scope="module")
def golden():
    return json.loads(NUMBERS.read_text())


@pytest.mark.parametrize("name", CASES)
def test_ten_training_steps_give_the_losses_that_they_gave(name, golden):
    losses = losses_of(name)
    assert losses == pytest.approx(golden[name], rel=1e-8, abs=0)
    assert losses[-1] < losses[0]


def bilinear(image, motion):
    """``image`` at the previous positions, borders repeated; ``motion (B, 2, h, w)`` is upsampled."""
    height, width = image.shape[-2:]
    motion = F.interpolate(motion, (height, width), mode="bilinear", align_corners=False)
    identity = torch.tensor([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]], dtype=image.dtype).expand(len(image), -1, -1)
    grid = F.affine_grid(identity, list(image.shape), align_corners=False) + 2.0 * motion.permute(0, 2, 3, 1)
    return F.grid_sample(image, grid, "bilinear", "border", align_corners=False)


def test_the_losses_of_dlctus_are_the_thesis_s(golden):
    """The listing of appendix A.1, equation 55 and Adam, from the same weights, with none of the project's modules."""
    thesis_step = runpy.run_path(str(ROOT / "tests" / "models" / "test_dlctus.py"))["thesis_step"]
    cfg, model = make("dlctus_clamp")
    weights = {k: v.detach().clone().requires_grad_() for k, v in model.state_dict().items()}

    def layer(name):
        return SimpleNamespace(weight=weights[f"{name}.weight"], bias=weights[f"{name}.bias"])

    blocks = [{0: layer(f"network.blocks.{k}.0"), 2: layer(f"network.blocks.{k}.2")} for k in range(4)]
    trunk = SimpleNamespace(down=layer("network.down"), blocks=blocks)
    optimizer = torch.optim.Adam(weights.values(), lr=cfg.budget.lr)
    data, losses = clip(), []
    h, w = LOW
    x = (2 * torch.arange(w, dtype=torch.float64) + 1) / w - 1
    y = (2 * torch.arange(h, dtype=torch.float64)[:, None] + 1) / h - 1
    lattice = torch.stack((x.expand(h, w), y.expand(h, w)), -1)
    for _ in range(STEPS):
        history, errors = None, []
        for t in range(FRAMES):
            color, depth, motion, jitter = (data[k][:, t] for k in ("color", "depth", "motion", "jitter"))
            grid = lattice + 2.0 * motion.permute(0, 2, 3, 1)
            output, history = thesis_step(trunk, SCALE, color, depth, grid, jitter + 0.5, history)
            errors.append(output - data["target"][:, t])
        counted = []
        for t in range(FRAMES - COUNTED, FRAMES):
            now, before = errors[t], bilinear(errors[t - 1], data["motion"][:, t])
            spatial = now.abs() + before.abs()
            counted.append(spatial + 0.1 * ((now - before).abs() - spatial))
        loss = torch.stack(counted).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert losses == pytest.approx(golden["dlctus_clamp"], rel=1e-8, abs=0)


if __name__ == "__main__":
    from supersampling.commands.resolvers import register

    os.environ["SUPERSAMPLING_ROOT"] = str(ROOT)
    register()
    torch.set_num_threads(1)
    NUMBERS.write_text(json.dumps({name: losses_of(name) for name in CASES}, indent=1) + "\n")
