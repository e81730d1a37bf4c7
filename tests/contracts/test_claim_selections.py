"""Every side of every claim composes as a command and has the selected parameters, or names what the project lacks."""

from functools import cache
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from model_cases import CONF, MODELS, SLOTS, family_of

from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.selection import matches
from supersampling.runs.identity import flat_parameters
from supersampling.runs.measurements import NO_METHOD
from supersampling.runs.store import Run

CLAIMS = {
    claim.id: claim
    for paper in load_papers(Path(CONF.parent / "reports" / "published"), None)
    for claim in paper.claims
}
# Methods and options that claims name and this project lacks; their claims say so in `needs`.
LACKING = {
    "model": {*("basicvsr_unidirectional", "rvrt", "vespcn", "vespcn_plus", "duf", "edsr"), *("dlss", "fsr2")},
    "model.kernel_prediction": {"table"},
}
LISTS = {"data.scenes": "scene"}
# What a benchmark says of a method beside its parameters.
OF_BENCHMARKS = ("size", "part", "backend")


def lacking(selection):
    return [f"{key}={value}" for key, value in selection.items() if value in LACKING.get(key, ())]


def trainings(selection):
    """The parameters of the training, and those that its weights are scored with if they are others."""
    plain = {k: value for k, value in selection.items() if not k.startswith(("test.", "trained.", *OF_BENCHMARKS))}
    trained = {key.removeprefix("trained."): value for key, value in selection.items() if key.startswith("trained.")}
    return [{**plain, **trained}, {**trained, **plain}]


def words(params):
    """The command of the first of each of the selected values: a stage's option is a group of its model."""
    slots = SLOTS[family_of(params["model"])]
    command = []
    for key, value in params.items():
        value = value.split("|")[0]
        if key == "budget.scheduler.total_steps":  # derived
            continue
        group = key.replace("model.", "model/", 1) if key.removeprefix("model.") in slots else key
        command.append(f"{LISTS[key]}=[{value}]" if key in LISTS else f"{group}={value}")
    # Groups first: a number is a number of the selected option.
    return sorted(command, key=lambda word: "." in word.split("=")[0])


@cache
def composed(command):
    GlobalHydra.instance().clear()
    scene = [] if "scene=" in command else ["scene=atrium"]
    with initialize_config_dir(str(CONF), version_base="1.3"):
        cfg = compose("train", [*scene, "budget=laptop", *command.split()], return_hydra_config=True)
    choices = cfg.hydra.runtime.choices
    cfg._set_flag(["struct", "readonly"], False)
    cfg.pop("hydra")
    params = {key: str(value) for key, value in flat_parameters(cfg, choices, True).items()}
    words = dict.fromkeys(("id", "name", "identity", "dataset", "method", "machine", "version"), "")
    return Run(**words, ended=0, params=params, metrics={})


@pytest.mark.parametrize("name", CLAIMS)
def test_the_sides_of_a_claim_are_commands(name):
    claim = CLAIMS[name]
    for label, selection in claim.selections.items():
        if lacking(selection):
            assert claim.needs, label
            continue
        if selection["model"] == NO_METHOD:
            continue
        assert selection["model"] in MODELS, label
        for wanted in trainings(selection):
            run = composed(" ".join(words(wanted)))
            differing = {k: run.params.get(k) for k, value in wanted.items() if not matches(run, {k: value})}
            assert not differing, (label, differing)
