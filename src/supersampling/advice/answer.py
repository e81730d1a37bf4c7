"""The answer of a search: a file for train.py, tables, and the run that keeps them."""

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
from supersampling.advice.cost import Cost, Size
from supersampling.advice.halving import Answer, Search
from supersampling.advice.prior import Reason
from supersampling.advice.prior import rows as reason_rows
from supersampling.advice.space import Composition
from supersampling.advice.trainings import Trainings
from supersampling.config import key_of
from supersampling.runs import tags
from supersampling.runs.experiment import Experiment
from supersampling.runs.keys import Effect, effect_of

SEED, SCENE = "seed", "scene"  # set by the search, and by the file itself


def experiment_file(overrides: Sequence[str], scenes: Sequence[str]) -> str:
    """An experiment of train.py that makes these overrides."""
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


@dataclass(frozen=True)
class Found:
    """All that a search was made of and gave."""

    scene: str
    space: str
    margin: float
    size: Size
    total: int
    compositions: Sequence[Composition]
    costs: Sequence[Cost]
    reasons: Sequence[Reason]
    trainings: Trainings
    search: Search
    answer: Answer
    parts: Sequence[Contribution]
    buffers: Sequence[dict[str, Any]]

    @property
    def chosen(self) -> Composition:
        return self.compositions[self.answer.chosen]

    def steps_of(self, rung: int, candidate: int) -> int:
        return self.trainings.composed(candidate, rung, 0).steps

    def search_table(self) -> pd.DataFrame:
        rows = [
            {
                "round": step.rung + 1,
                "steps": self.steps_of(step.rung, step.candidate),
                "seeds": len(self.search.values[step.rung, step.candidate]),
                "composition": self.compositions[step.candidate].name,
                "ms": self.costs[step.candidate].ms,
                "psnr": step.mean,
                "loss": step.loss.mean,
                "low": _plain(step.loss.low),
                "high": _plain(step.loss.high),
                "verdict": step.verdict,
            }
            for step in self.search.steps
        ]
        return pd.DataFrame(rows)

    def parts_table(self) -> pd.DataFrame:
        rows = [
            {
                "part": f"{c.switch}={c.part}",
                "against": c.without,
                "kept": self.chosen.options.get(c.switch) == c.part,
                "round": c.rung + 1,
                "pairs": c.pairs,
                "db": _plain(c.db.mean),
                "low": _plain(c.db.low),
                "high": _plain(c.db.high),
                "ms": c.ms,
            }
            for c in self.parts
        ]
        return pd.DataFrame(rows, columns=["part", "against", "kept", "round", "pairs", "db", "low", "high", "ms"])

    def summary(self) -> dict[str, Any]:
        """One row: the answer, and what it took."""
        loss = self.answer.losses[self.answer.chosen]
        last = len(self.trainings.rungs.epochs) - 1
        seeds = self.trainings.rungs.seeds[last]
        a_training = sum(self.steps_of(last, c) for c in range(len(self.compositions))) / len(self.compositions)
        spent, minutes = self.trainings.spent, self.trainings.minutes
        walk = round(self.total * seeds * a_training)
        saved = [row for row in self.buffers if not row["needed"]]
        return {
            "scene": self.scene,
            "space": self.space,
            "size": f"{self.size.width}x{self.size.height}",
            "margin": self.margin,
            "clips": loss.clips,
            "seeds": seeds,
            "chosen": self.chosen.name,
            "best": self.compositions[self.answer.best].name,
            "loss": loss.mean,
            "low": _plain(loss.low),
            "high": _plain(loss.high),
            "ms": self.costs[self.answer.chosen].ms,
            "best_ms": self.costs[self.answer.best].ms,
            "unresolved": "; ".join(self.compositions[c].name for c in self.answer.open),
            "left_out": ", ".join(row["buffer"] for row in saved),
            "left_out_mb": sum(row["bytes"] for row in saved) / 1e6,
            "of_mb": sum(row["bytes"] for row in self.buffers) / 1e6,
            "compositions": self.total,
            "searched": len(self.compositions),
            "trainings": self.trainings.count,
            "steps": spent,
            "minutes": minutes,
            "walk_trainings": self.total * seeds,
            "walk_steps": walk,
            "walk_minutes": minutes / spent * walk if spent else 0.0,
        }


def _plain(value: float) -> float | None:
    return None if math.isnan(value) else value


def log(experiment: Experiment, found: Found, dataset: str, facts: pd.DataFrame, text: str) -> str:
    """A run of kind ``advice``; every table is an artifact. Returns its id."""
    run_tags = {
        tags.KIND: "advice",
        tags.DATASET: dataset,
        tags.SCENE: found.scene,
        tags.SPACE: found.space,
        tags.METHOD: found.chosen.name,
    }
    run_id = experiment.start(f"advice {found.space} on {found.scene}", run_tags, None)
    client = experiment.client
    client.log_table(run_id, found.search_table(), "search.json")
    client.log_table(run_id, found.parts_table(), "contributions.json")
    client.log_table(run_id, pd.DataFrame(reason_rows(found.reasons)), "reasons.json")
    client.log_table(run_id, pd.DataFrame(list(found.buffers)), "buffers.json")
    client.log_table(run_id, facts, "facts.json")
    client.log_table(run_id, pd.DataFrame([found.summary()]), "summary.json")
    client.log_text(run_id, text, "advice.yaml")
    experiment.finish(run_id)
    return run_id


def write(text: str, out: Path, name: str) -> Path:
    """The experiment file, whole or not at all."""
    path = out / "experiment" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(".part")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)
    return path


def overrides_of(found: Found) -> list[str]:
    """Those of the answer's training."""
    last = len(found.trainings.rungs.epochs) - 1
    own = [o for o in found.trainings.rungs.overrides(last, 0) if key_of(o) != "seed"]
    return [*found.chosen.overrides, *own]
