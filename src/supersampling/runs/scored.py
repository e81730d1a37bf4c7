"""The parameters of an evaluation: of what was scored, and of what the weights were trained with where that differs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from supersampling.config import choices
from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError
from supersampling.runs.identity import flat_parameters
from supersampling.runs.method import LoadedMethod
from supersampling.runs.naming import is_learned
from supersampling.runs.relation import FILES, RUN, SCENES, TRAINED, UNKNOWN, UNSEEN, in_order, relation
from supersampling.runs.sanity import protocol_parameters

# What a training reads, and what only says how or repeats the task.
_TRAINING = ("data.train", "data.val")
_REPEATED = ("data.workers", "data.scale", "data.jitter", "data.mip_bias", "data.test")


def scored_parameters(cfg: DictConfig, method: LoadedMethod, files: Sequence[Path]) -> dict[str, Any]:
    """Return the parameters of the evaluation of a method on the test ``files``.

    Those of the model are the scored model's; those of loss, budget and training clips are the training's; those of
    the data and the task are the test's.
    """
    protocol = protocol_parameters(cfg)
    training = method.training
    if training is None:  # nothing was trained, or nothing is known of it: then no report reads the evaluation
        scenes = {} if is_learned(method.model) else {SCENES: UNSEEN}
        return {**method.parameters, **protocol, **scenes}
    configured = flat_parameters(cfg, choices(), False)
    scored = {name: value for name, value in method.parameters.items() if not _of_test(name)}
    scored |= {name: value for name, value in configured.items() if _of_test(name)}
    tested = {read_spec(path).scene for path in files}
    if scored.get("data") == FILES != training.get("data"):  # ``scene`` says nothing of files
        scored["data.scenes"] = ",".join(sorted(tested))
    return {
        **scored,
        **_differing(training, scored),
        RUN: method.origin.get("run") or UNKNOWN,
        **protocol,
        SCENES: relation(tested, _trained_scenes(training)),
    }


def _of_test(name: str) -> bool:
    """Return whether a parameter says what is scored on."""
    return name == "data" or (name.startswith(("data.", "task.")) and not name.startswith(_TRAINING))


def _differing(training: Mapping[str, Any], scored: Mapping[str, Any]) -> dict[str, str]:
    """Return the training's own value of each parameter of model, data and task that was scored with another one."""
    names = sorted({name for name in (*training, *scored) if name.startswith("model.") or _of_test(name)})
    return {
        f"{TRAINED}{name}": _text(name, training)
        for name in names
        if not name.startswith(_REPEATED) and _text(name, training) != _text(name, scored)
    }


def _text(name: str, parameters: Mapping[str, Any]) -> str:
    """Return a parameter as text; scenes in alphabetical order."""
    value = str(parameters.get(name, UNKNOWN))
    return in_order(value) if name == "data.scenes" else value


def _trained_scenes(training: Mapping[str, Any]) -> set[str]:
    """Return the scenes of a training as their files name them; empty if they are not known."""
    if str(training.get("data", FILES)) == FILES:
        try:
            return {read_spec(Path(path)).scene for path in str(training.get("data.train", "")).split(",") if path}
        except (UserError, OSError):
            return set()
    stem = Path(str(training.get("data.path", ""))).stem
    scenes = str(training.get("data.scenes", "")).split(",")
    return {f"gltf/{stem}" if scene == "gltf" else scene for scene in scenes if scene}
