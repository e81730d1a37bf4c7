"""The meaning of each top-level key of the configuration for a run: the one table of identities, parameters and
searches."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any


class Effect(Enum):
    """The effect of changing a key."""

    WEIGHTS = "the trained weights or tuned constants"
    SCORES = "how the same weights are scored"
    CONTENT = "the data; identities hold the fingerprint of what was rendered instead"
    NOTHING = "where and how a job runs"
    COMMAND = "one command, none of whose settings reach a training"


@dataclass(frozen=True)
class Key:
    """The meaning of one key.

    Attributes:
        learned: whether it concerns learned methods only.
        shown: whether MLflow shows it as a parameter.
        compared: the beginning of its parameters that tell configurations of a method apart in reports, empty if none.
    """

    effect: Effect
    learned: bool = False
    shown: bool = True
    compared: str = ""


_NOTHING = Key(Effect.NOTHING, shown=False)
_COMMAND = Key(Effect.COMMAND, shown=False)

# Arguments of Lightning that change when a training stops, or what is printed and validated, but no weight.
_TRAINER_NOTHING = [
    f"trainer.{name}"
    for name in (
        *("strategy", "max_time", "limit_val_batches", "val_check_interval", "inference_mode"),
        *("deterministic", "benchmark", "detect_anomaly", "profiler", "enable_autolog_hparams"),
    )
]

KEYS: dict[str, Key] = {
    "model": Key(Effect.WEIGHTS, compared="model."),
    "task": Key(Effect.WEIGHTS, compared="task."),
    "tune": Key(Effect.WEIGHTS, shown=False),
    "recipe": Key(Effect.WEIGHTS, shown=False),  # a group without a node: it selects task, loss and pick
    "loss": Key(Effect.WEIGHTS, learned=True, compared="loss"),
    "pick": Key(Effect.WEIGHTS, learned=True, compared="pick"),
    "augment": Key(Effect.WEIGHTS, learned=True, compared="augment"),
    "optimizer": Key(Effect.WEIGHTS, learned=True, compared="optimizer"),
    "budget": Key(Effect.WEIGHTS, learned=True, compared="budget."),
    "trainer": Key(Effect.WEIGHTS, learned=True, compared="trainer.precision"),
    "trainer.enable_progress_bar": Key(Effect.NOTHING),
    "trainer.accelerator": Key(Effect.NOTHING),
    "trainer.devices": Key(Effect.NOTHING),
    **dict.fromkeys(_TRAINER_NOTHING, Key(Effect.NOTHING)),
    "seed": Key(Effect.WEIGHTS, learned=True),
    "protocol": Key(Effect.SCORES, compared="protocol"),
    "data": Key(Effect.CONTENT, compared="data.train."),
    "scene": Key(Effect.CONTENT, shown=False),
    "path": Key(Effect.CONTENT, shown=False),
    **dict.fromkeys(("metrics", "paths", "logger", "tracking_uri", "experiment_name", "hydra"), _NOTHING),
    **dict.fromkeys(("threads", "workers", "fresh", "baselines", "sweeps", "experiment", "debug"), _NOTHING),
    # advise
    **dict.fromkeys(
        ("margin", "rungs", "seeds", "steps", "search", "trials", "walk", "prune", "size", "frames"), _COMMAND
    ),
    **dict.fromkeys(("render_costs", "out", "among"), _COMMAND),
    # benchmark, count, pick
    **dict.fromkeys(("methods", "run", "scales", "sizes", "precisions", "rounds", "seconds", "depth"), _COMMAND),
    **dict.fromkeys(("device", "cost", "rendering", "backends", "ms", "db", "low_ms", "high_ms", "dataset"), _COMMAND),
    # evaluate, export, stress
    **dict.fromkeys(("checkpoint", "capture", "name", "space", "kernels", "check", "tolerance"), _COMMAND),
    **dict.fromkeys(("models", "extremes", "effort", "quick", "all"), _COMMAND),
    # render, show, import_capture, export_capture
    **dict.fromkeys(("splits", "buffers", "pictures", "layout", "convention", "jitter_convention"), _COMMAND),
    **dict.fromkeys(("reversed_depth", "file", "split", "clip", "frame", "width", "columns"), _COMMAND),
    **dict.fromkeys(("video", "video_width", "fps"), _COMMAND),
    # report, compare
    **dict.fromkeys(("paper", "output", "published", "templates", "a", "b", "metric"), _COMMAND),
}


def effect_of(key: str) -> Effect:
    """Return the effect of a key or group such as ``model/reproject`` or ``loss.theta``."""
    return KEYS[key.replace("/", ".").partition(".")[0]].effect


def select(config: Mapping[str, Any], effects: set[Effect], learned: bool) -> dict[str, Any]:
    """Return the entries of a resolved configuration whose keys have one of these effects.

    Args:
        learned: whether the method is trained; keys that concern learned methods only are left out if not.
    """
    return dict(_selected(config, "", effects, learned))


def _selected(config: Mapping[str, Any], prefix: str, effects: set[Effect], learned: bool) -> Iterator[tuple[str, Any]]:
    for name, value in config.items():
        key = KEYS.get(f"{prefix}{name}")
        if prefix and key is None:
            yield name, value
        elif key is not None and key.effect in effects and (learned or not key.learned):
            nested = isinstance(value, Mapping) and any(known.startswith(f"{name}.") for known in KEYS)
            yield name, dict(_selected(value, f"{name}.", effects, learned)) if nested else value


def is_shown(key: str, learned: bool) -> bool:
    """Return whether MLflow shows a key or group as a parameter of a run."""
    entry = KEYS.get(key.replace("/", ".").partition(".")[0], _NOTHING)
    return entry.shown and (learned or not entry.learned)


def compared_parameters() -> tuple[str, ...]:
    """Return the beginnings of all parameters that tell configurations of a method apart in reports."""
    return tuple(key.compared for key in KEYS.values() if key.compared)
