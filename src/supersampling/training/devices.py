"""The devices of a training: their number, and what `lightning.Trainer` gets for them."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import lightning as L
from lightning.fabric.utilities.exceptions import MisconfigurationException
from lightning.pytorch.plugins.environments import LightningEnvironment
from omegaconf import DictConfig, OmegaConf

from supersampling.errors import UserError

# Lightning's names of its one strategy whose devices each hold the whole model. They differ in how processes start,
# which `supersampling.training.processes` does in one way, and in whether parameters may be unused.
_STRATEGY = re.compile(r"ddp(_spawn|_fork|_forkserver|_notebook)?(_find_unused_parameters_(true|false))?")


@dataclass(frozen=True)
class Devices:
    """The number of devices, with a process for each, and the arguments of `lightning.Trainer` that concern them."""

    count: int
    arguments: Mapping[str, Any]


def devices_of(cfg: DictConfig) -> Devices:
    """Return the devices that a configuration trains on.

    ``trainer.devices=auto`` takes as many of the machine's devices as ``budget.batch`` can be dealt out to.

    Raises:
        UserError: the machine does not have the devices, the windows of a batch cannot be dealt out to them, the
            strategy is another one than DDP, several machines are asked for, or another program has started this
            process as one of several.
    """
    _check_launch()
    _check_nodes(cfg)
    strategy = _checked_strategy(cfg)
    devices = OmegaConf.select(cfg, "trainer.devices")
    devices = "auto" if devices is None else OmegaConf.to_object(devices) if OmegaConf.is_list(devices) else devices
    count = _count(cfg, devices)
    if devices == "auto":
        count = devices = max(n for n in range(1, count + 1) if cfg.budget.batch % n == 0)
    elif cfg.budget.batch % count:
        raise UserError(
            f"budget.batch={cfg.budget.batch} cannot be dealt out equally to {count} devices (trainer.devices="
            f"{devices}): use a multiple of {count}, or fewer devices."
        )
    arguments = {
        "devices": devices,
        "strategy": "auto" if count == 1 else strategy,
        "num_nodes": 1,
        "use_distributed_sampler": False,  # our samplers deal out
        "plugins": [LightningEnvironment()],  # rather than what variables of Slurm or MPI say
    }
    return Devices(count, arguments)


def _check_launch() -> None:
    """Raise `UserError` in a process that another program has started as one of several."""
    size, rank = os.environ.get("WORLD_SIZE", "1"), os.environ.get("LOCAL_RANK", "0")
    if size != "1" or rank != "0":
        raise UserError(
            f"WORLD_SIZE={size} and LOCAL_RANK={rank} are set, as torchrun sets them for one of several processes: "
            "start the command once, without torchrun, with trainer.devices=N (it starts the processes), or unset the "
            "variables."
        )


def _check_nodes(cfg: DictConfig) -> None:
    nodes = OmegaConf.select(cfg, "trainer.num_nodes")
    if nodes not in (None, 1):
        raise UserError(
            f"trainer.num_nodes={nodes} is not supported: a job trains on one machine, so use trainer.num_nodes=1 and "
            "trainer.devices=N."
        )


def _checked_strategy(cfg: DictConfig) -> str:
    """Return Lightning's name of the strategy for several devices."""
    strategy = OmegaConf.select(cfg, "trainer.strategy")
    if strategy in (None, "auto", "single_device"):
        strategy = "ddp"
    match = _STRATEGY.fullmatch(str(strategy))
    if match is None:
        raise UserError(
            f"trainer.strategy={strategy} is not supported: use ddp, ddp_spawn, ddp_fork or ddp_notebook, which are "
            "the same here, or leave the setting out."
        )
    # One device accepts parameters without a gradient, so several do.
    return f"ddp_find_unused_parameters_{match[3] or 'true'}"


def _count(cfg: DictConfig, devices: Any) -> int:
    if isinstance(devices, bool):  # Lightning takes true for 1
        raise UserError(f"Invalid trainer.devices={devices}: use a whole number, a list of device numbers, or auto.")
    try:
        trainer = L.Trainer(
            accelerator=OmegaConf.select(cfg, "trainer.accelerator") or "auto",
            devices=devices,
            logger=False,
            enable_checkpointing=False,
            enable_progress_bar=False,
            enable_model_summary=False,
            plugins=[LightningEnvironment()],
        )
    except (MisconfigurationException, ValueError, TypeError, RuntimeError) as error:
        reason = " ".join(str(error).split()).rstrip(".")
        raise UserError(
            f"trainer.devices={devices} with trainer.accelerator={OmegaConf.select(cfg, 'trainer.accelerator')} is not "
            f"possible ({reason}): use devices that the machine has, or leave both settings out."
        ) from error
    return int(trainer.num_devices)
