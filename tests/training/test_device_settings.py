"""The devices of a training: how many, what Lightning gets, and what is refused."""

import re

import pytest
from lightning.pytorch.accelerators import CPUAccelerator, CUDAAccelerator
from omegaconf import OmegaConf

from supersampling.errors import UserError
from supersampling.training.devices import devices_of


def devices(batch=2, **trainer):
    """Return the devices of a configuration with this batch and these settings of the trainer."""
    return devices_of(OmegaConf.create({"budget": {"batch": batch}, "trainer": {"accelerator": "cpu", **trainer}}))


@pytest.fixture
def machine(monkeypatch):
    """Return a function that gives the machine this many devices."""
    return lambda count: monkeypatch.setattr(CPUAccelerator, "auto_device_count", staticmethod(lambda: count))


@pytest.mark.parametrize(("value", "count"), [("auto", 1), (None, 1), (1, 1), (2, 2), ("2", 2)], ids=str)
def test_a_process_for_each_device(value, count):
    result = devices(devices=value)
    assert result.count == count
    assert (result.arguments["strategy"] == "auto") == (count == 1)


@pytest.mark.parametrize(("batch", "count"), [(16, 8), (4, 4), (12, 6), (7, 7), (11, 1)])
def test_auto_takes_the_devices_that_a_batch_can_be_dealt_out_to(machine, batch, count):
    machine(8)
    result = devices(batch, devices="auto")
    assert result.count == result.arguments["devices"] == count


@pytest.mark.parametrize("start", ["ddp", "ddp_spawn", "ddp_fork", "ddp_notebook"])
@pytest.mark.parametrize(("suffix", "unused"), [("", "true"), ("_true", "true"), ("_false", "false")])
def test_all_names_of_ddp_are_the_same_here(start, suffix, unused):
    strategy = f"{start}_find_unused_parameters{suffix}" if suffix else start
    assert devices(devices=2, strategy=strategy).arguments["strategy"] == f"ddp_find_unused_parameters_{unused}"
    assert devices(devices=1, strategy=strategy).arguments["strategy"] == "auto"


IMPOSSIBLE = "with trainer.accelerator=cpu is not possible"


@pytest.mark.parametrize(
    ("trainer", "message"),
    [
        ({"devices": 3}, "budget.batch=2 cannot be dealt out equally to 3 devices (trainer.devices=3): use a multiple"),
        ({"strategy": "fsdp"}, "trainer.strategy=fsdp is not supported: use ddp, ddp_spawn, ddp_fork or ddp_notebook"),
        ({"strategy": "deepspeed_stage_2", "devices": 2}, "trainer.strategy=deepspeed_stage_2 is not supported"),
        ({"strategy": "dp"}, "trainer.strategy=dp is not supported"),
        ({"strategy": {"name": "ddp"}}, "trainer.strategy={'name': 'ddp'} is not supported"),
        ({"num_nodes": 2}, "trainer.num_nodes=2 is not supported: a job trains on one machine"),
        ({"devices": 0}, f"trainer.devices=0 {IMPOSSIBLE}"),
        ({"devices": -2}, f"trainer.devices=-2 {IMPOSSIBLE}"),
        ({"devices": "many"}, f"trainer.devices=many {IMPOSSIBLE}"),
        ({"devices": 1.5}, f"trainer.devices=1.5 {IMPOSSIBLE}"),
        ({"devices": True}, "Invalid trainer.devices=True: use a whole number, a list of device numbers, or auto"),
        ({"devices": [0, 1]}, f"trainer.devices=[0, 1] {IMPOSSIBLE}"),
        ({"devices": 2, "accelerator": "gpu"}, "trainer.devices=2 with trainer.accelerator=gpu is not possible"),
        ({"devices": 2, "accelerator": "fpga"}, "trainer.devices=2 with trainer.accelerator=fpga is not possible"),
    ],
    ids=str,
)
def test_refused_in_a_sentence(monkeypatch, trainer, message):
    monkeypatch.setattr(CUDAAccelerator, "is_available", staticmethod(lambda: False))
    with pytest.raises(UserError, match=re.escape(message)) as refusal:
        devices(**trainer)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("variables", [{"WORLD_SIZE": "2", "LOCAL_RANK": "0"}, {"LOCAL_RANK": "1"}], ids=str)
def test_a_process_of_torchrun_is_refused(monkeypatch, variables):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(UserError, match="start the command once, without torchrun, with trainer.devices=N"):
        devices(devices=2)


def test_variables_of_slurm_change_nothing(monkeypatch):
    for name, value in {
        "SLURM_NTASKS": "4",
        "SLURM_JOB_NAME": "night",
        "SLURM_PROCID": "0",
        "SLURM_LOCALID": "0",
    }.items():
        monkeypatch.setenv(name, value)
    assert devices(devices=2).count == 2
