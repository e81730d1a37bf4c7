"""Tables and claims that evaluations fill: exchanged stages, unseen scenes, other cameras; on example runs."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from example_runs import example_run

from supersampling.reporting.papers.claims import choose_claim
from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.schema import Claim, PublishedTable
from supersampling.reporting.papers.tables import choose_table
from supersampling.reporting.selection import matches, settings
from supersampling.reporting.settings import Choice, Setting, choose
from supersampling.runs.store import Run

PUBLISHED = Path(__file__).resolve().parents[2] / "reports" / "published"
PAPERS = {name: load_paper(PUBLISHED / f"{name}.yaml") for name in ("dlctus", "nsrd", "nsrr", "enss")}
DLCTUS = {"model.accumulate": "buffer", "model.dilate": "none", "loss": "l1", "budget": "laptop", "seed": "0"}
NSRD = {
    "model": "nsrd", "model.demodulate": "lighting", "model.recur": "convlstm", "model.motion_mask": "dual",
    "budget": "laptop_nsrd",
}  # fmt: skip
NSRR = {
    "model": "nsrr", "model.previous": "2", "model.guides": "none", "model.demodulate": "display",
    "budget": "laptop_nsrr",
}  # fmt: skip
PRIMARY = {
    "model": "nsrr", "model.previous": "4", "model.extract": "learned", "model.reweight": "learned",
    "model.upsample": "zero", "model.warp_at": "target", "budget": "laptop_nsrr",
}  # fmt: skip


def job(name: str, params: dict[str, str], dataset: str = "aaaa", **more: Any) -> Run:
    item = example_run(name, dataset=dataset, **more)
    return replace(item, params={**item.params, **params})


def evaluation(name: str, params: dict[str, str], dataset: str = "aaaa", scenes: str = "same") -> Run:
    return replace(job(name, {**params, "test.scenes": scenes, "trained.run": "t"}, dataset), kind="evaluation")


def unseen(name: str, params: dict[str, str], scene: str = "market", trained: str = "atrium") -> Run:
    data = {"data.scenes": scene, "trained.data.scenes": trained}
    return evaluation(name, {**params, **data}, f"of {scene}", "unseen")


def table_of(paper: str, number: str) -> PublishedTable:
    return next(table for table in PAPERS[paper].tables if table.number == number)


def claim_of(name: str) -> Claim:
    return next(claim for claim in PAPERS[name.partition("-")[0]].claims if claim.id == name)


def cells(table: PublishedTable, runs: list[Run]) -> dict[tuple[str, str], list[str]]:
    """Return the names of the runs by the labels of row and column."""
    selected = choose_table(table, choose(runs, None, None))
    return {
        ("/".join(table.rows[row].labels), table.columns[column].label): [run.name for run in members]
        for (row, column), members in selected.cells.items()
    }


def sides(name: str, runs: list[Run]) -> dict[str, list[str]]:
    selected = choose_claim(claim_of(name), choose(runs, None, None))
    return {label: [run.name for run in members] for label, members in selected.runs.items()}


def dlctus(reproject: str) -> dict[str, str]:
    return {**DLCTUS, "model.reproject": reproject}


def exchanged(name: str, reproject: str, trained: str = "bicubic9", **more: str) -> Run:
    params = {name.replace("__", "."): value for name, value in more.items()}
    return evaluation(name, {**dlctus(reproject), "trained.model.reproject": trained, **params})


TRAINING = job("training", dlctus("bicubic9"))
EXCHANGED = [exchanged("tested 1", "bilinear"), exchanged("tested 5", "bicubic5")]


def test_the_thesis_exchanges_the_reprojection_of_one_training() -> None:
    runs = [TRAINING, *EXCHANGED, job("trained 1", dlctus("bilinear")), job("trained 5", dlctus("bicubic5"))]
    assert cells(table_of("dlctus", "13"), runs) == {
        ("4×4/1", "Bilinear"): ["tested 1"],
        ("4×4/1", "Bicubic5"): ["tested 5"],
        ("4×4/1", "Bicubic9"): ["training"],
    }
    assert sides("dlctus-6", runs) == {"b": ["tested 1"], "a": ["training"]}
    assert sides("dlctus-7", runs) == {"b": ["tested 5"], "a": ["training"]}


def test_the_thesis_exchanges_dilation() -> None:
    closest = exchanged("closest", "bicubic9", "bicubic9", model__dilate="closest", trained__model__dilate="none")
    assert sides("dlctus-9", [TRAINING, closest]) == {"b": ["training"], "a": ["closest"]}
    dilated = job("trained closest", {**dlctus("bicubic9"), "model.dilate": "closest"})
    assert sides("dlctus-9", [TRAINING, dilated]) == {"b": ["training"], "a": []}
    assert cells(table_of("dlctus", "14"), [TRAINING, closest, dilated]) == {
        ("4×4/1", "dilated motion vectors"): ["closest"],
        ("4×4/1", "without dilation"): ["training"],
    }


def test_an_exchange_of_another_training_does_not_count() -> None:
    other = exchanged("trained with bicubic5", "bilinear", trained="bicubic5")
    unnamed = exchanged("other dilation", "bilinear", model__dilate="closest", trained__model__dilate="none")
    assert sides("dlctus-6", [TRAINING, other, unnamed])["b"] == []


def test_what_no_cell_names_agrees_in_the_training_too() -> None:
    """Another exchange beside the compared one is told from the training by what was trained."""
    same = exchanged("same", "bilinear")
    second = exchanged("second", "bilinear", model__confine="clamp", trained__model__confine="sigmoid")
    training = job("training", {**dlctus("bicubic9"), "model.confine": "clamp"})
    first = replace(same, params={**same.params, "model.confine": "clamp"})
    assert not all(sides("dlctus-6", [training, second]).values())
    assert sides("dlctus-6", [training, second, first])["b"] == ["same"]
    assert settings(second)["trained.model.confine"] == "sigmoid"


def test_evaluations_never_fill_what_asks_for_trainings() -> None:
    plain = {"model": "dlctus", "model.reproject": "bilinear"}
    assert not matches(EXCHANGED[0], plain)
    assert matches(EXCHANGED[0], {**plain, "trained.model.reproject": "bicubic9"})
    assert not matches(EXCHANGED[0], {**plain, "trained.model.reproject": "bilinear"})
    assert matches(TRAINING, {"trained.model.reproject": "bicubic9", "test.scenes": "same"})
    choice = choose([TRAINING, *EXCHANGED], None, None)
    assert [run.name for run in choice.pools[choice.setting]] == ["training"]


def test_scenes_of_a_training_match_in_any_order() -> None:
    run = unseen("a", NSRD, trained="foundry,atrium")
    assert matches(run, {"trained.data.scenes": "atrium,foundry"})
    assert not matches(run, {"trained.data.scenes": "atrium"})


def test_evaluations_of_earlier_versions_and_of_unknown_data_do_not_count() -> None:
    old = replace(EXCHANGED[0], params={k: v for k, v in EXCHANGED[0].params.items() if k != "test.scenes"})
    assert sides("dlctus-6", [TRAINING, old])["b"] == []
    assert not matches(job("files", {"data": "files"}), {"test.scenes": "same"})


JOINT = {"data.scenes": "atrium,bar"}


def test_generalisation_is_judged_on_scenes_that_were_not_trained_on() -> None:
    trainings = [job("nsrd", NSRD), job("nsrr", NSRR)]
    on_trained = [evaluation("nsrd again", NSRD), evaluation("nsrr again", NSRR)]
    assert sides("nsrd-10", trainings) == {"b": ["nsrr"], "a": ["nsrd"]}
    assert sides("nsrd-16", [*trainings, *on_trained]) == {"b": [], "a": []}
    assert cells(table_of("nsrd", "4"), [*trainings, *on_trained]) == {}
    new = [unseen("nsrd on market", NSRD), unseen("nsrr on market", NSRR)]
    assert sides("nsrd-16", [*trainings, *new]) == {"b": ["nsrr on market"], "a": ["nsrd on market"]}
    assert cells(table_of("nsrd", "4"), [*trainings, *new]) == {
        ("Bistro", "NSRR"): ["nsrr on market"],
        ("Bistro", "Ours"): ["nsrd on market"],
    }


def test_compared_networks_were_trained_on_the_same_scenes() -> None:
    runs = [job("nsrd", NSRD), unseen("a", NSRD), unseen("b", NSRR, trained="foundry")]
    assert sides("nsrd-16", runs) == {"b": [], "a": ["a"]}
    (_, setting), *rest = choose_table(table_of("nsrd", "4"), choose(runs, None, None)).settings.items()
    assert not rest
    assert str(setting).endswith("budget=laptop, trained with data.scenes=atrium")


def test_a_scene_alone_with_others_and_without_itself() -> None:
    own = {"data.scenes": "bar"}
    runs = [
        job("joint", {**PRIMARY, **JOINT}),
        job("alone", {**PRIMARY, **own}, "of bar"),
        job("fast", {**PRIMARY, **own, "model": "nsrr_fast"}, "of bar"),
        evaluation("all", {**PRIMARY, **own, "trained.data.scenes": "atrium,bar"}, "of bar", "subset"),
        unseen("others", PRIMARY, "bar"),
        unseen("elsewhere", PRIMARY, "foundry"),
    ]
    table = cells(table_of("nsrr", "3"), runs)
    assert {column: names for (row, column), names in table.items() if row == "bar"} == {
        "Ours-Fast": ["fast"],
        "Ours": ["alone"],
        "Ours-AllScenes": ["all"],
        "Ours-AllButOne": ["others"],
    }
    assert {row for row, _ in table} == {"bar", "foundry"}


def test_seeds_of_a_cell_were_trained_on_the_same_scenes() -> None:
    runs = [job("x", {**PRIMARY, **JOINT}), job("alone", {**PRIMARY, "data.scenes": "bar"}, "of bar")]
    for seed in ("0", "1"):
        runs.append(unseen(f"two {seed}", {**PRIMARY, "seed": seed}, "bar", "atrium,foundry"))
    runs.append(unseen("one 2", {**PRIMARY, "seed": "2"}, "bar", "atrium"))
    assert cells(table_of("nsrr", "3"), runs)["bar", "Ours-AllButOne"] == ["two 0", "two 1"]


@pytest.fixture
def medium() -> dict[str, str]:
    base = {k: v.split("|")[0] for k, v in claim_of("enss-23").base.items() if k != "data.camera"}
    return {**base, "budget": "laptop"}


def test_cameras_of_the_training_are_compared_on_one_test_set(medium: dict[str, str]) -> None:
    stops = job("stops", {**medium, "data.camera": "stops"}, "of stops")
    walk = job("walk", {**medium, "data.camera": "walk"}, "of walk")
    tested = {**medium, "data.camera": "stops", "trained.data.camera": "walk"}
    runs = [stops, walk, evaluation("walk on stops", tested, "of stops")]
    assert sides("enss-23", runs[:2]) == {"b": ["stops"], "a": []}
    assert sides("enss-23", runs) == {"b": ["stops"], "a": ["walk on stops"]}


def test_a_chosen_data_set_keeps_the_evaluations_of_its_trainings() -> None:
    training = job("t", NSRD)
    mine, other = unseen("mine", NSRD), unseen("other", NSRD)
    other = replace(other, params={**other.params, "trained.run": "elsewhere"})

    def names(choice: Choice) -> set[str]:
        return {run.name for pool in choice.tested.values() for run in pool}

    assert names(choose([training, mine, other], "aa", None)) == {"t", "mine"}
    assert Setting.of(mine).dataset == "of market"


def test_untrained_methods_join_evaluations_on_their_test_set() -> None:
    jau = job("jau", {"model": "jau", "data.scenes": "market"}, "of market")
    pools = choose([job("nsrd", NSRD), job("nsrr", NSRR), unseen("market", NSRD), jau], None, None).tested
    assert {frozenset(run.name for run in pool) for pool in pools.values()} == {
        frozenset({"nsrd", "nsrr"}),
        frozenset({"market", "jau"}),
    }
