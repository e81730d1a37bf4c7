"""The command ``advise``: measure the scene, leave out what it cannot need, search the rest, answer."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import torch
from omegaconf import DictConfig

from supersampling.advice import answer, tell
from supersampling.advice.facts import Fact, measure
from supersampling.advice.prior import Reason, prune, within
from supersampling.advice.search import Question, search, varied
from supersampling.advice.settings import settings_of
from supersampling.advice.space import Space
from supersampling.advice.trainings import Composed
from supersampling.config import key_of, typed_overrides
from supersampling.data.dataset_file import DatasetFile
from supersampling.data.module import fingerprint
from supersampling.runs.experiment import experiment_of
from supersampling.runs.keys import Effect, effect_of
from supersampling.training.job import data_files

SEED = "seed"  # the search sets its own


def training_overrides(overrides: Sequence[str]) -> list[str]:
    """Return the overrides that hold for the trainings, not for the search."""
    return [
        override
        for override in overrides
        if key_of(override) != SEED
        and not key_of(override).startswith("hydra")
        and effect_of(key_of(override)) is not Effect.COMMAND
    ]


def advise(cfg: DictConfig) -> None:
    """Print and log the answer, and write it as an experiment of train.py.

    Raises:
        UserError: a setting that is not possible, an unknown scene, a search that cannot be afforded, nothing that trains.
    """
    settings = settings_of(cfg)
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    whole = settings.space.fixed(training_overrides(typed_overrides()))
    space, reasons = _held(whole)
    files = data_files(cfg, [c.cfg for c in varied(space)])
    paths = [path for split in files.values() for path in split]
    scenes = _scenes(files["test"])
    facts = measure(paths, scenes)
    tell.facts(scenes, facts)
    if settings.prune:
        space, more = prune(space, facts)
        said = {reason.switch for reason in reasons}
        reasons += [reason for reason in more if reason.switch not in said or not reason.tried]
    tell.reasons(reasons)
    found = search(Question(cfg, settings, whole, space, reasons, files, experiment, scenes))
    text = answer.experiment_file(answer.overrides_of(found), _configured(cfg))
    name = f"{found.scene.replace('/', '_').replace(',', '_')}_{space.name}"
    path = answer.write(text, settings.out, name)
    run_id = answer.log(experiment, found, fingerprint(files["test"], ["target"]), _table(facts), text)
    tell.found(found)
    tell.after(path, name, settings.out, run_id)


def _held(space: Space) -> tuple[Space, list[Reason]]:
    """Of a user's own files: the space of what they hold."""
    plain = Composed.of(space.compositions()[-1].overrides)
    if not str(plain.cfg.data._target_).endswith(".Files"):
        return space, []
    held: list[frozenset[str]] = []
    for split in ("train", "val", "test"):
        for name in plain.cfg.data[split]:
            store = DatasetFile(Path(name))
            held.append(store.buffers)
            store.close()
    if not held:
        return space, []
    return within(space, frozenset.intersection(*held), lambda c: Composed.of(c.overrides).reads)


def _scenes(test: Sequence[Path]) -> list[str]:
    names = []
    for path in test:
        store = DatasetFile(path)
        names.append(store.spec.scene)
        store.close()
    return names


def _configured(cfg: DictConfig) -> list[str]:
    return [cfg.scene] if isinstance(cfg.scene, str) else list(cfg.scene)


def _table(facts: dict[str, Fact]) -> pd.DataFrame:
    return pd.DataFrame([{"fact": k, "value": f.value, "source": f.source, "about": f.about} for k, f in facts.items()])
