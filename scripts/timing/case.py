"""A training step to time: its configuration, its objects, a clip of noise, and the plain step."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lightning as L
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import DictConfig
from torch import Tensor
from torch.profiler import record_function

ROOT = Path(__file__).resolve().parents[2]
os.environ.setdefault("SUPERSAMPLING_ROOT", str(ROOT))

from supersampling.commands.resolvers import register  # noqa: E402
from supersampling.frames import BUFFERS  # noqa: E402
from supersampling.losses import Loss  # noqa: E402
from supersampling.models.base import Upsampler  # noqa: E402
from supersampling.training.module import unroll  # noqa: E402

MODELS = ("dlctus", "nsrr", "nsrd", "enss_s", "enss_m")


def cases(overrides: list[str]) -> dict[str, DictConfig]:
    """Return the configuration of each method at the laptop budget, all with one recipe, whose loss needs no weights.

    ``overrides`` are those of train.py; ``model=a,b`` selects methods.
    """
    register()
    selected = [o.removeprefix("model=") for o in overrides if o.startswith("model=")]
    rest = [o for o in overrides if not o.startswith("model=")]
    if not any(o.startswith("budget=") for o in rest):
        rest.insert(0, "budget=laptop")
    if not any(o.startswith("recipe=") for o in rest):
        rest.insert(0, "recipe=dlctus")
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        names = selected[0].split(",") if selected else MODELS
        return {name: compose("train", [f"model={name}", *rest]) for name in names}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A method with its loss, optimizer, schedule, and a batch in memory; the loss reads the last ``outputs``."""

    model: Upsampler
    loss: Loss
    optimizer: torch.optim.Optimizer
    scheduler: Any
    outputs: int
    clip: Mapping[str, Tensor]
    device: torch.device

    @classmethod
    def from_config(cls, cfg: DictConfig) -> "Case":
        """Instantiate a configuration on the device that training would use."""
        L.seed_everything(0, verbose=False)
        device = L.Fabric(accelerator=cfg.trainer.accelerator, devices=1).device
        model, loss = instantiate(cfg.model).to(device), instantiate(cfg.loss).to(device)
        optimizer = instantiate(cfg.optimizer)(model.parameters())
        outputs = cfg.budget.counted + loss.previous
        return cls(
            model=model,
            loss=loss,
            optimizer=optimizer,
            scheduler=instantiate(cfg.budget.scheduler)(optimizer),
            outputs=outputs,
            clip=noise(cfg, model.requires | model.compares | loss.requires, outputs, device),
            device=device,
        )

    def step(self) -> None:
        """Run one plain training step, its phases marked for a profiler."""
        with record_function("forward"):
            outputs = unroll(self.model, self.clip, self.outputs)
        with record_function("loss"):
            frames = {name: values[:, -self.outputs :] for name, values in self.clip.items()}
            value = self.loss(outputs, self.model.reference(frames), frames)
        with record_function("backward"):
            value.backward()
        with record_function("optimiser"):
            self.optimizer.step()
            self.optimizer.zero_grad()
            self.scheduler.step()


def noise(cfg: DictConfig, names: frozenset[str], outputs: int, device: torch.device) -> dict[str, Tensor]:
    """Return a random batch with a loader's shapes; high-resolution buffers cover the last ``outputs`` frames."""
    batch, high = cfg.budget.batch, cfg.budget.crop
    clip = {}
    for name in sorted(names):
        buffer = BUFFERS[name]
        side = {"low": (high // cfg.task.scale,) * 2, "high": (high,) * 2, "frame": ()}[buffer.resolution]
        frames = outputs if buffer.resolution == "high" else cfg.budget.frames
        values = torch.rand(batch, frames, buffer.channels, *side, device=device)
        if buffer.kind == "plane":
            values = (values - 0.5) * (1.0 if buffer.resolution == "frame" else 0.04)
        clip[name] = values
    return clip
