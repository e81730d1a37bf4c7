"""The command ``advise``: measure the scene, leave out what it cannot need, search the rest, and answer."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import torch
from omegaconf import DictConfig

from supersampling.advice import printing
from supersampling.advice.answer import experiment_file, log_answer, write_experiment
from supersampling.advice.facts import Fact, measure_facts
from supersampling.advice.prior import Reason, prune, restrict_to_buffers
from supersampling.advice.search import Question, representative_configs, search
from supersampling.advice.settings import read_settings
from supersampling.advice.space import Space
from supersampling.advice.trainings import TrainingConfig
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
        UserError: a setting is invalid, a scene is unknown, the search takes too many steps, or no composition can be
            trained.
    """
    settings = read_settings(cfg)
    torch.set_num_threads(cfg.threads)
    experiment = experiment_of(cfg)
    whole = settings.space.fix(training_overrides(typed_overrides()))
    space, reasons = _restrict_to_files(whole)
    files = data_files(cfg, [config.cfg for config in representative_configs(space)])
    scenes = _read_scenes(files["test"])
    facts = measure_facts([path for split in files.values() for path in split], scenes)
    printing.print_facts(scenes, facts)
    if settings.prune:
        space, more = prune(space, facts)
        explained = {reason.switch for reason in reasons}
        reasons += [reason for reason in more if reason.switch not in explained or not reason.searched]
    printing.print_reasons(reasons)
    result = search(
        Question(
            cfg=cfg,
            settings=settings,
            whole=whole,
            space=space,
            reasons=reasons,
            files=files,
            experiment=experiment,
            scenes=scenes,
        )
    )
    text = experiment_file(result.overrides(), [cfg.scene] if isinstance(cfg.scene, str) else list(cfg.scene))
    name = f"{result.scene.replace('/', '_').replace(',', '_')}_{space.name}"
    path = write_experiment(text, settings.out, name)
    run_id = log_answer(experiment, result, fingerprint(files["test"], ["target"]), _facts_table(facts), text)
    printing.print_result(result)
    printing.print_commands(path, name, settings.out, run_id)


def _restrict_to_files(space: Space) -> tuple[Space, list[Reason]]:
    """Return the space that a user's own files allow, and the reasons; for rendered data, the whole space."""
    plain = TrainingConfig.compose(space.compositions()[-1].overrides)
    if not str(plain.cfg.data._target_).endswith(".Files"):
        return space, []
    available: list[frozenset[str]] = []
    for split in ("train", "val", "test"):
        for name in plain.cfg.data[split]:
            file = DatasetFile(Path(name))
            available.append(file.buffers)
            file.close()
    if not available:
        return space, []
    return restrict_to_buffers(
        space, frozenset.intersection(*available), lambda c: TrainingConfig.compose(c.overrides).buffers
    )


def _read_scenes(test: Sequence[Path]) -> list[str]:
    scenes = []
    for path in test:
        file = DatasetFile(path)
        scenes.append(file.spec.scene)
        file.close()
    return scenes


def _facts_table(facts: dict[str, Fact]) -> pd.DataFrame:
    rows = [{"fact": k, "value": f.value, "source": f.source, "about": f.about} for k, f in facts.items()]
    return pd.DataFrame(rows)
