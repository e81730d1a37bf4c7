"""The answer of a search: a file for train.py, tables, and the run that stores them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import OmegaConf

from supersampling.advice.contributions import Contribution
from supersampling.advice.cost import FrameTime, Size
from supersampling.advice.halving import Decision, Halving
from supersampling.advice.prior import Reason, reason_rows
from supersampling.advice.space import ModelComposition
from supersampling.advice.trainings import Trainings
from supersampling.config import key_of
from supersampling.runs import tables, tags
from supersampling.runs.experiment import Experiment
from supersampling.runs.keys import Effect, effect_of

SEED, SCENE = "seed", "scene"  # the search sets the seed, the file the scene
CONTRIBUTION_COLUMNS = ["part", "against", "kept", "round", "pairs", "db", "low", "high", "ms"]


def experiment_file(overrides: Sequence[str], scenes: Sequence[str]) -> str:
    """Return an experiment of train.py that sets these overrides."""
    groups: list[Any] = []
    values = OmegaConf.create({})
    loader = GlobalHydra.instance().config_loader()
    for override in OverridesParser.create().parse_overrides(list(overrides)):
        key = override.key_or_group
        if key in (SEED, SCENE) or effect_of(key) in (Effect.NOTHING, Effect.COMMAND) or key.startswith("trainer"):
            continue
        if "." not in key and loader.get_group_options(key):
            groups.append({f"override /{key}": override.value()})
        else:
            OmegaConf.update(values, key, override.value(), force_add=True)
    # A model before its stages.
    groups.sort(key=lambda group: next(iter(group)).count("/"))
    values["scene"] = scenes[0] if len(scenes) == 1 else list(scenes)
    content = OmegaConf.create({"defaults": groups})
    return "# @package _global_\n" + OmegaConf.to_yaml(content) + "\n" + OmegaConf.to_yaml(values)


@dataclass(frozen=True, kw_only=True)
class SearchResult:
    """The inputs and the results of a search; ``total`` counts the compositions of the whole space."""

    scene: str
    space: str
    margin: float
    size: Size
    total: int
    compositions: Sequence[ModelComposition]
    costs: Sequence[FrameTime]
    reasons: Sequence[Reason]
    trainings: Trainings
    halving: Halving
    decision: Decision
    contributions: Sequence[Contribution]
    buffers: Sequence[dict[str, Any]]

    @property
    def answer(self) -> ModelComposition:
        """The selected composition."""
        return self.compositions[self.decision.selected]

    @property
    def unneeded_buffers(self) -> list[dict[str, Any]]:
        """The rows of the buffers that the answer does not read."""
        return [row for row in self.buffers if not row["needed"]]

    def includes(self, contribution: Contribution) -> bool:
        """Return whether the part of a contribution is in the answer."""
        return self.answer.options.get(contribution.switch) == contribution.part

    def overrides(self) -> list[str]:
        """Return the overrides of the answer's training."""
        rungs = self.trainings.rungs
        return [*self.answer.overrides, *(o for o in rungs.overrides(rungs.last, 0) if key_of(o) != SEED)]

    def search_table(self) -> pd.DataFrame:
        """Return one row per candidate and rung."""
        rows = [
            {
                "round": result.rung + 1,
                "steps": self.trainings.steps_per_seed(result.candidate, result.rung),
                "seeds": len(self.halving.values[result.rung, result.candidate]),
                "composition": self.compositions[result.candidate].name,
                "ms": self.costs[result.candidate].ms,
                "psnr": result.mean,
                "loss": result.loss.mean,
                "low": _none_if_nan(result.loss.low),
                "high": _none_if_nan(result.loss.high),
                "verdict": result.verdict,
            }
            for result in self.halving.results
        ]
        return pd.DataFrame(rows)

    def contributions_table(self) -> pd.DataFrame:
        """Return one row per contribution."""
        rows = [
            {
                "part": f"{c.switch}={c.part}",
                "against": c.without,
                "kept": self.includes(c),
                "round": c.rung + 1,
                "pairs": c.pairs,
                "db": _none_if_nan(c.db.mean),
                "low": _none_if_nan(c.db.low),
                "high": _none_if_nan(c.db.high),
                "ms": c.ms,
            }
            for c in self.contributions
        ]
        return pd.DataFrame(rows, columns=CONTRIBUTION_COLUMNS)

    def summary(self) -> dict[str, Any]:
        """Return one row: the answer, and the effort of the search."""
        decision, trainings = self.decision, self.trainings
        loss = decision.losses[decision.selected]
        count, last = len(self.compositions), trainings.rungs.last
        seeds = trainings.rungs.seeds[last]
        mean_steps = sum(trainings.steps_per_seed(c, last) for c in range(count)) / count
        spent, minutes = trainings.spent, trainings.minutes
        walk = round(self.total * seeds * mean_steps)
        unneeded = self.unneeded_buffers
        return {
            "scene": self.scene,
            "space": self.space,
            "size": f"{self.size.width}x{self.size.height}",
            "margin": self.margin,
            "clips": loss.clips,
            "seeds": seeds,
            "chosen": self.answer.name,
            "best": self.compositions[decision.best].name,
            "loss": loss.mean,
            "low": _none_if_nan(loss.low),
            "high": _none_if_nan(loss.high),
            "ms": self.costs[decision.selected].ms,
            "best_ms": self.costs[decision.best].ms,
            "unresolved": "; ".join(self.compositions[c].name for c in decision.unresolved),
            "left_out": ", ".join(row["buffer"] for row in unneeded),
            "left_out_mb": sum(row["bytes"] for row in unneeded) / 1e6,
            "of_mb": sum(row["bytes"] for row in self.buffers) / 1e6,
            "compositions": self.total,
            "searched": count,
            "trainings": trainings.count,
            "steps": spent,
            "minutes": minutes,
            "walk_trainings": self.total * seeds,
            "walk_steps": walk,
            "walk_minutes": minutes / spent * walk if spent else 0.0,
        }


def _none_if_nan(value: float) -> float | None:
    return None if math.isnan(value) else value


def log_answer(experiment: Experiment, result: SearchResult, dataset: str, facts: pd.DataFrame, text: str) -> str:
    """Log a run of kind ``advice``, with every table as an artifact; return its id."""
    run_tags = {
        tags.KIND: "advice",
        tags.DATASET: dataset,
        tags.SCENE: result.scene,
        tags.SPACE: result.space,
        tags.METHOD: result.answer.name,
    }
    run_id = experiment.start(f"advice {result.space} on {result.scene}", run_tags, None)
    artifacts = {
        tables.SEARCH: result.search_table(),
        tables.CONTRIBUTIONS: result.contributions_table(),
        tables.REASONS: pd.DataFrame(reason_rows(result.reasons)),
        tables.BUFFERS: pd.DataFrame(list(result.buffers)),
        tables.FACTS: facts,
        tables.SUMMARY: pd.DataFrame([result.summary()]),
    }
    for name, table in artifacts.items():
        experiment.client.log_table(run_id, table, name)
    experiment.client.log_text(run_id, text, tables.ANSWER)
    experiment.finish(run_id)
    return run_id


def write_experiment(text: str, out: Path, name: str) -> Path:
    """Write the experiment file, completely or not at all; return its path."""
    path = out / "experiment" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".part")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)
    return path
