"""Every cell, series, picture and claim that selects runs is filled by a job of the sweep that the file names."""

from functools import cache

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from model_cases import CONF
from test_claim_selections import lacking
from test_sweeps import IN_MINUTES, SWEEPS, jobs_of

from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.selection import matches
from supersampling.runs.identity import flat_parameters
from supersampling.runs.relation import SCENES, TRAINED
from supersampling.runs.store import Run

PUBLISHED = CONF.parent / "reports" / "published"
PAPERS = {name: load_paper(PUBLISHED / f"{name}.yaml") for name in ("nsrd", "dlctus")}
PICTURED = {name: load_paper(PUBLISHED / f"{name}.yaml") for name in ("nsrr", "nsrd", "enss", "dlctus")}
# Series of a picture that another sweep runs: Xiao et al. beside ENSS.
ELSEWHERE = {("enss", "Xiao et al."): "enss_table2_xiao"}
# Classical methods run by themselves beside each job.
BASELINES = ("model=bicubic", "model=jau", "model=tus_thesis", "model=tus")
FORMS = [(name, "") for name in SWEEPS] + [(name, words) for name, (words, _) in IN_MINUTES.items()]


@cache
def parameters(command, learned):
    GlobalHydra.instance().clear()
    words = command.split()
    scene = [] if any(word.startswith("scene=") for word in words) else ["scene=atrium"]
    with initialize_config_dir(str(CONF), version_base="1.3"):
        cfg = compose("train", [*scene, *words], return_hydra_config=True)
    choices = cfg.hydra.runtime.choices
    cfg._set_flag(["struct", "readonly"], False)
    cfg.pop("hydra")
    params = {k: str(v) for k, v in flat_parameters(cfg, choices, learned).items()}
    words = dict.fromkeys(("id", "name", "identity", "dataset", "method", "machine", "version"), "")
    return Run(**words, ended=0, params=params, metrics={})


@cache
def runs_of(sweep, form):
    runs = []
    for job in jobs_of(sweep, *form.split()):
        runs.append(parameters(" ".join(job), True))
        task = [word for word in job if word.startswith("task")]
        runs += [parameters(" ".join([*task, baseline]), False) for baseline in BASELINES]
    return runs


def training_of(selection):
    """What the training of an evaluation has: evaluate.py exchanges stages and selects the test data."""
    trained = {name.removeprefix(TRAINED): value for name, value in selection.items() if name.startswith(TRAINED)}
    plain = {name: value for name, value in selection.items() if not name.startswith(TRAINED) and name != SCENES}
    return plain | trained


def filled(selection, forms):
    selection = training_of(selection)
    return any(matches(run, selection) for form in forms for run in runs_of(*form))


def cells():
    for paper in PAPERS.values():
        for table in paper.tables:
            if table.file is None:
                continue
            file = table.file or f"{paper.paper}_table{table.number}"
            for row in table.rows:
                for column in table.columns:
                    if row.select is not None and column.select is not None:
                        selection = {**table.base, **row.select, **column.select}
                        yield pytest.param(
                            file, selection, id=f"{paper.paper} {table.number} {'/'.join(row.labels)} {column.label}"
                        )
        for figure in paper.figures:
            for series in figure.series:
                name = f"{paper.paper} figure {figure.number} {series.label}"
                if figure.sweep:
                    yield pytest.param(figure.sweep, {**figure.base, **series.select}, id=name)


@pytest.mark.parametrize(("file", "selection"), cells())
def test_a_cell_has_a_job(file, selection):
    assert filled(selection, [form for form in FORMS if form[0].startswith(file)])


def pictures():
    for name, paper in PICTURED.items():
        for picture in paper.pictures:
            for label, selection in picture.selections.items():
                sweep = ELSEWHERE.get((name, label), picture.sweep)
                if sweep is not None:
                    yield pytest.param(sweep, selection, id=f"{name} {picture.number} {label}")


@pytest.mark.parametrize(("file", "selection"), pictures())
def test_a_picture_has_a_job(file, selection):
    assert filled(selection, [form for form in FORMS if form[0] == file])


# A longer training than a table's, runs that evaluate.py makes of a training, and what benchmark.py measures.
NO_ROW = ("budget.epochs", "test.", "trained.", "size")
BY_ITSELF = "jau_bicubic"


@pytest.mark.parametrize("name", PAPERS)
def test_both_sides_of_a_claim_have_jobs(name):
    forms = [form for form in FORMS if form[0].startswith(name)]
    for claim in PAPERS[name].claims:
        for label, selection in claim.selections.items():
            if lacking(selection) or any(key.startswith(NO_ROW) for key in selection):
                continue
            assert selection["model"] == BY_ITSELF or filled(selection, forms), (claim.id, label)
