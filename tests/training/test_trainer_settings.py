"""Every argument of `lightning.Trainer`: a value that works is passed on, any other is refused in one sentence."""

import inspect

import lightning as L
import pytest
import torch
from omegaconf import OmegaConf, open_dict

from supersampling.errors import UserError
from supersampling.training.check import GROUPS, check_training
from supersampling.training.schedule import optimizer_steps, scheduled
from supersampling.training.trainer_arguments import NAMES, RESERVED, RULES, duration
from supersampling.training.trainer_settings import arguments, explained_failures

DEVICES = {"accelerator", "devices", "strategy", "num_nodes", "use_distributed_sampler"}


@pytest.fixture(scope="module")
def base():
    from hydra import compose, initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra

    from supersampling.resources import resources

    GlobalHydra.instance().clear()
    with initialize_config_dir(str(resources() / "conf"), version_base="1.3"):
        return compose("train", ["scene=atrium", "budget=smoke", "trainer.accelerator=cpu"])


@pytest.fixture
def configured(base, monkeypatch):
    """Return a function that returns the smoke training with these settings."""
    for name in NAMES:
        monkeypatch.delenv(f"PL_TRAINER_{name.upper()}", raising=False)

    def configure(**settings):
        cfg = base.copy()
        for key, value in settings.items():
            OmegaConf.update(cfg, key.replace("__", "."), value, force_add=True)
        return cfg

    return configure


def test_the_tables_name_every_argument_once():
    assert set(NAMES) == set(inspect.signature(L.Trainer).parameters)
    assert {*RESERVED, *RULES, *DEVICES} == set(NAMES)
    assert not set(RESERVED) & set(RULES)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("precision", value) for value in ("32-true", 32, "64", 64, "64-true", "bf16", "bf16-true", "bf16-mixed")),
        *(("gradient_clip_val", value) for value in (None, 0, 0.5, 1)),
        *(("accumulate_grad_batches", value) for value in (None, 1, 64)),
        *(("limit_train_batches", value) for value in (None, 1, 1.0, 0.5, 2.0, 10**6)),
        *(("limit_val_batches", value) for value in (None, 0, 0.0, 1, 0.25)),
        *(("val_check_interval", value) for value in (None, 1, 2, 0.5, 1.0, "00:00:01:00", {"minutes": 5})),
        *(("max_time", value) for value in (None, "00:12:00:00", {"hours": 1.5})),
        *(("deterministic", value) for value in (None, True, False, "warn")),
        *((name, value) for name in ("benchmark", "inference_mode", "detect_anomaly") for value in (True, False)),
        *(("profiler", value) for value in (None, "simple", "advanced", "pytorch")),
        *(("max_steps", value) for value in (None, -1)),
        *(("fast_dev_run", False), ("enable_checkpointing", True), ("callbacks", None), ("overfit_batches", 0.0)),
    ],
)
def test_value_that_works(configured, name, value):
    check_training(configured(**{f"trainer__{name}": value}))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("precision", value) for value in ("fp16", "16-true", "transformer-engine", "", True, 8, "16-mixed", 16)),
        *(("accelerator", value) for value in ("tpu", "mps", "hpu", "gpus", "", 3, True, ["cpu"])),
        *(("devices", value) for value in (0, -1, "abc", [], 1.5, {"a": 1})),
        *(("strategy", value) for value in ("dp", "", "ddp2", 3)),
        *(("num_nodes", value) for value in (0, "two")),
        *(("gradient_clip_val", value) for value in (-1, "abc", True, float("nan"), float("inf"), [1], "1")),
        *(("gradient_clip_algorithm", value) for value in ("l2", 2, "norm")),
        *(("accumulate_grad_batches", value) for value in (0, -1, 1.5, "2", True, {4: 2})),
        *(("limit_train_batches", value) for value in (0, 0.0, -1, 1.5, 0.1, "half", True, float("nan"))),
        *(("limit_val_batches", value) for value in (-1, 1.5, "all", True)),
        *(("val_check_interval", value) for value in (0, 0.0, 3, -0.5, 1.5, "1h", True, {"minutes": 0})),
        *(("max_time", value) for value in (600, "10 minutes", "00:10:00", "00:00:00:00", {"minutes": -1}, {"m": 1})),
        *(("max_time", value) for value in ({"minutes": "x"}, {"days": 10**12}, [1], True, "")),
        *(("deterministic", value) for value in ("yes", 1, "error")),
        *((name, value) for name in ("benchmark", "inference_mode", "detect_anomaly") for value in (1, "on", [True])),
        *((name, "on") for name in ("enable_progress_bar", "sync_batchnorm", "enable_autolog_hparams")),
        *(("profiler", value) for value in ("xla", "fast", True, 1)),
        *(("fast_dev_run", value) for value in (True, 1, 5, "yes")),
        *(("max_epochs", 1), ("min_epochs", 1), ("max_steps", 10), ("min_steps", 1), ("overfit_batches", 1)),
        *(("check_val_every_n_epoch", 1), ("num_sanity_val_steps", 2), ("log_every_n_steps", 50), ("logger", True)),
        *(("callbacks", []), ("enable_model_summary", True), ("enable_checkpointing", False), ("barebones", True)),
        *(("limit_test_batches", 1), ("limit_predict_batches", 1), ("plugins", []), ("default_root_dir", "/tmp")),
        *(("model_registry", "x"), ("reload_dataloaders_every_n_epochs", 1), ("foo", 1), ("max_epoch", 3)),
    ],
)
def test_value_that_is_refused(configured, name, value):
    with pytest.raises(UserError, match=rf"trainer\.{name}=") as caught:
        check_training(configured(**{f"trainer__{name}": value}))
    sentence = str(caught.value)
    assert str(value) in sentence
    assert ": " in sentence
    assert sentence[-1] in ".?"
    assert "\n" not in sentence


def test_unknown_argument_names_its_neighbour(configured):
    with pytest.raises(
        UserError, match=r"no argument max_epoch \(trainer.max_epoch=3\): did you mean trainer.max_epochs"
    ):
        check_training(configured(trainer__max_epoch=3))


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("value", [None, "word"])
def test_group_without_an_option(configured, group, value):
    with pytest.raises(UserError, match=f"Invalid {group}={value}: use {group}=OPTION, one of "):
        check_training(configured(**{group: value}))


def test_missing_group(configured):
    cfg = configured()
    with open_dict(cfg):
        cfg["trainer"] = None
    with pytest.raises(UserError, match="Invalid trainer=None: use trainer=OPTION, one of default"):
        check_training(cfg)


def test_variable_of_the_environment(configured, monkeypatch):
    monkeypatch.setenv("PL_TRAINER_MAX_STEPS", "3")
    with pytest.raises(UserError, match="PL_TRAINER_MAX_STEPS=3 would change a training that does not name it"):
        check_training(configured())


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("budget.epochs", value) for value in (0, -1, 1.5, None, "two", True)),
        *(("budget.lr", value) for value in (0, -1, float("nan"), float("inf"), None, "fast")),
        *(("budget.validate_every", value) for value in (0, 1.5, None)),
        *(("workers", value) for value in (-1, 1000, None, "all")),
        *(("seed", value) for value in (-1, 2**40, None, 0.5)),
        *(("threads", value) for value in (0, None, "all")),
        *(("optimizer.betas", [2, 2]), ("optimizer.weight_decay", -1), ("optimizer.weight_decay", "abc")),
        *(("optimizer.foo", 1), ("budget.scheduler.pct_start", 3), ("budget.scheduler.foo", 1)),
        *(("budget.scheduler.total_steps", 3), ("budget.scheduler.total_steps", 0)),
    ],
)
def test_number_that_is_refused(configured, key, value):
    with pytest.raises(UserError, match=key.rpartition(".")[0] or key) as caught:
        check_training(configured(**{key.replace(".", "__"): value}))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "steps"),
    [
        ({}, 2 * 10),
        ({"trainer__accumulate_grad_batches": 3}, 2 * 4),
        ({"trainer__limit_train_batches": 0.35}, 2 * 3),
        ({"trainer__limit_train_batches": 3, "trainer__accumulate_grad_batches": 2}, 2 * 2),
        ({"trainer__limit_train_batches": 10**6}, 2 * 10),
    ],
    ids=str,
)
def test_steps_are_those_of_lightning(configured, settings, steps):
    cfg = configured(budget__steps=10, **settings)
    trainer = L.Trainer(**arguments(cfg, 1), max_epochs=2, logger=False, enable_checkpointing=False)
    module = L.LightningModule()
    module.training_step = lambda batch: None  # type: ignore[method-assign]
    trainer.strategy.connect(module)
    trainer.fit_loop._data_source.instance = torch.utils.data.DataLoader(range(10))
    assert trainer.estimated_stepping_batches == optimizer_steps(cfg) == steps
    assert scheduled(cfg).budget.scheduler.total_steps == steps
    assert scheduled(cfg).budget.steps == 10


@pytest.mark.parametrize(
    ("budget", "key", "expected"),
    [("enss", "milestones", [100_000, 200_000]), ("nsrd", "step_size", 50 * 641 + 50), ("laptop", "total_steps", 1500)],
)
def test_every_budget_s_schedule_counts_the_steps(entry, budget, key, expected):
    cfg = entry("train", "scene=atrium", f"budget={budget}", "++trainer.accumulate_grad_batches=2")
    assert scheduled(cfg).budget.scheduler[key] == expected


def test_fraction_of_the_validation_is_at_least_a_clip(configured):
    cfg = configured(trainer__limit_val_batches=0.1)
    assert arguments(cfg, 4)["limit_val_batches"] == 1
    assert arguments(cfg, 40)["limit_val_batches"] == 4


def failing_operation():
    torch.use_deterministic_algorithms(True)
    raise RuntimeError("grid_sampler does not have a deterministic implementation, but you set ...")


def test_a_job_leaves_torch_as_it_was(configured):
    cfg = configured(trainer__deterministic=True, trainer__benchmark=True)
    check_training(cfg)
    assert not torch.are_deterministic_algorithms_enabled()
    with (
        pytest.raises(UserError, match=r"needs grid_sampler, .* so use trainer.deterministic=warn"),
        explained_failures(),
    ):
        failing_operation()
    assert not torch.are_deterministic_algorithms_enabled()


@pytest.mark.parametrize("value", ["00:00:10:00", "0:00:10:00", {"minutes": 10}])
def test_duration(value):
    assert duration(value).total_seconds() == 600
