"""The arguments of `lightning.Trainer` as ``trainer.`` takes them: the values of each that works, and what to use
instead of each that is refused.

`docs/train.md` has the same table in words.
"""

import inspect
import math
from collections.abc import Callable, Mapping
from datetime import timedelta
from typing import Any, NamedTuple

import lightning as L
from lightning.pytorch.callbacks import Timer
from lightning.pytorch.utilities.exceptions import MisconfigurationException

NAMES = tuple(inspect.signature(L.Trainer).parameters)
PRECISIONS = ("32-true", "64-true", "bf16-true", "bf16-mixed", "16-mixed")
# Lightning's other names of the same; half precision alone (16-true) is left out: Adam's steps become NaN in it.
PRECISION_NAMES = (*PRECISIONS, "64", "32", "16", "bf16", 64, 32, 16)
PROFILERS = ("simple", "advanced", "pytorch")
LONGEST = timedelta(days=3650)


class Reserved(NamedTuple):
    """An argument that a job sets itself or that cannot work: what to use instead, and the values that ask nothing."""

    advice: str
    harmless: tuple[Any, ...] = ()


class Values(NamedTuple):
    """The values of an argument: a test, and their description."""

    allows: Callable[[Any], bool]
    words: str


_EPOCHS = "use budget.epochs, and budget.steps for the steps of each epoch"
_LOADED = "leave it out: train.py scores whole test clips itself, as protocol=... and metrics=... say"

RESERVED: dict[str, Reserved] = {
    "max_epochs": Reserved(_EPOCHS),
    "min_epochs": Reserved(_EPOCHS),
    "max_steps": Reserved(_EPOCHS, (-1,)),
    "min_steps": Reserved(_EPOCHS),
    "fast_dev_run": Reserved("use budget=smoke for a quick run, or debug=one_step for a single step", (False,)),
    "overfit_batches": Reserved(
        "leave it out: every training sample is a new window, so no batch can be repeated. Name a small file with "
        "data=files data.train=[FILE] to try whether a method can learn it by heart",
        (0,),
    ),
    "reload_dataloaders_every_n_epochs": Reserved(
        "leave it out: the files of a training do not change, and every epoch takes new windows from them", (0,)
    ),
    "check_val_every_n_epoch": Reserved("use budget.validate_every"),
    "num_sanity_val_steps": Reserved("use debug=one_step to try the validation before a long training", (0,)),
    "log_every_n_steps": Reserved("use budget.steps: losses are logged once per epoch, which has budget.steps steps"),
    "logger": Reserved("use tracking_uri and experiment_name: a job logs to MLflow"),
    "callbacks": Reserved("leave it out: a job sets its own callbacks"),
    "enable_model_summary": Reserved("use count.py, which prints the size of a method", (False,)),
    "enable_checkpointing": Reserved("leave it out: a job continues from its checkpoint and is scored by it", (True,)),
    "barebones": Reserved("leave it out: a job needs its checkpoint and its log", (False,)),
    "limit_test_batches": Reserved(_LOADED),
    "limit_predict_batches": Reserved(_LOADED),
    "plugins": Reserved("leave it out: plugins are objects of Python, which no setting can name"),
    "default_root_dir": Reserved("use paths.checkpoints for the folder of checkpoints and profiles"),
    "use_distributed_sampler": Reserved("leave it out: the windows of a batch are dealt out to devices", (True, False)),
    "model_registry": Reserved("leave it out: a checkpoint is an artifact of its MLflow run"),
}


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_whole(value: Any, least: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _is_share(value: Any) -> bool:
    """Return whether a value is a number of batches or, if it has a point and is at most 1, a fraction of them."""
    return _is_number(value) and value > 0 and (value <= 1 or value % 1 == 0)


def duration(value: Any) -> timedelta | None:
    """Return a time as Lightning reads it, ``00:12:00:00`` or ``{hours: 12}``; None if it is none or not positive."""
    if not isinstance(value, (str, Mapping)):
        return None
    try:
        seconds = Timer(duration=dict(value) if isinstance(value, Mapping) else value).time_remaining()
        time = timedelta(seconds=seconds or 0.0)
    except (MisconfigurationException, TypeError, ValueError, OverflowError):
        return None
    return time if timedelta(0) < time <= LONGEST else None


def _choice(*options: Any) -> Values:
    return Values(
        lambda value: any(value == option and type(value) is type(option) for option in options),
        " or ".join(str(option).lower() if isinstance(option, bool) else str(option) for option in options),
    )


_SWITCH = _choice(True, False)
_TIME = "a time such as 00:12:00:00 (days, hours, minutes, seconds) or {hours:12}"

RULES: dict[str, Values] = {
    "precision": Values(_choice(*PRECISION_NAMES).allows, f"{', '.join(PRECISIONS[:-1])} or {PRECISIONS[-1]}"),
    "gradient_clip_val": Values(lambda value: _is_number(value) and value >= 0, "a number of at least 0, or null"),
    "gradient_clip_algorithm": _choice("norm", "value"),
    "accumulate_grad_batches": Values(lambda value: _is_whole(value, 1), "a whole number of at least 1"),
    "limit_train_batches": Values(_is_share, "a number of batches of at least 1, or a fraction such as 0.5"),
    "limit_val_batches": Values(
        lambda value: _is_number(value) and (value == 0 or _is_share(value)),
        "a number of clips, 0 for none, or a fraction such as 0.5",
    ),
    "val_check_interval": Values(
        lambda value: _is_share(value) or duration(value) is not None,
        f"a number of batches of at least 1, a fraction of an epoch such as 0.5, or {_TIME}",
    ),
    "max_time": Values(lambda value: duration(value) is not None, _TIME),
    "deterministic": _choice(True, False, "warn"),
    "profiler": _choice(*PROFILERS),
    **dict.fromkeys(("benchmark", "inference_mode", "detect_anomaly", "enable_progress_bar"), _SWITCH),
    **dict.fromkeys(("enable_autolog_hparams", "sync_batchnorm"), _SWITCH),
}
