"""The report of a store with evaluations: an exchanged stage, and scenes that were not trained on."""

from pathlib import Path

import pandas as pd
import pytest
from stored_runs import Log, config, mean_of, ours

from supersampling.commands.report import report

NSRD = {
    "model.demodulate": "lighting", "model.recur": "convlstm", "model.motion_mask": "dual", "budget": "laptop_nsrd",
    "seed": 0, "loss": "l1",
}  # fmt: skip
NSRR = {
    "model.previous": 2, "model.guides": "none", "model.demodulate": "display", "budget": "laptop_nsrr", "seed": 0,
    "loss": "l1",
}  # fmt: skip


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    log = Log(tmp_path_factory.mktemp("store"))
    log.run("dlctus", 34.0, "training")
    log.run("dlctus", 34.9, "trained with bilinear", params={"model.reproject": "bilinear"})
    exchanged = {"model.reproject": "bilinear", "trained.model.reproject": "bicubic9", "test.scenes": "same"}
    evaluation = {"ss.kind": "evaluation"}
    log.run("dlctus", 33.0, "exchanged", params=exchanged, tags=evaluation)
    for model, params, psnr in (("nsrd", NSRD, 26.0), ("nsrr", NSRR, 30.0)):
        log.run(model, psnr, f"{model} training", params=params)
        seen = {**params, "test.scenes": "same"}
        log.run(model, psnr, f"{model} seen", params=seen, tags=evaluation)
        unseen = {**params, "data.scenes": "market", "trained.data.scenes": "atrium", "test.scenes": "unseen"}
        # NSRD is the worse one where it was trained, and the better one on the unseen scene.
        log.run(
            model, 56.0 - psnr, f"{model} unseen", params=unseen, tags={**evaluation, "ss.dataset": "77aa00bb11cc22dd"}
        )
    return log


def claims(folder: Path, paper: str) -> pd.DataFrame:
    return pd.read_csv(folder / f"{paper}_claims.csv").set_index("claim")


def test_the_exchanged_stage_stands_in_the_thesis_s_table(log: Log, tmp_path: Path) -> None:
    report(config(log, tmp_path))
    cells = ours(tmp_path, 13).xs("PSNR", level="metric")["ours"]
    assert cells["4×4/1", "Bilinear"] == pytest.approx(mean_of(log, "psnr", ("exchanged",)))
    assert cells["4×4/1", "Bicubic9"] == pytest.approx(mean_of(log, "psnr", ("training",)))
    assert claims(tmp_path, "dlctus").loc["dlctus-6", "verdict"] == "reproduced"
    methods = pd.read_csv(tmp_path / "dlctus_overview.csv").iloc[:, 0].tolist()
    assert sorted(methods) == ["dlctus", "dlctus, reproject=bilinear", "nsrd", "nsrr"], "trainings only"


def test_generalisation_stands_on_unseen_scenes(log: Log, tmp_path: Path) -> None:
    report(config(log, tmp_path, paper="nsrd"))
    table = pd.read_csv(tmp_path / "nsrd_table4.csv").set_index(["row", "column", "metric"])
    cells = table.xs("PSNR", level="metric")
    assert cells.loc[("Bistro", "Ours"), "ours"] == pytest.approx(mean_of(log, "psnr", ("nsrd unseen",)))
    assert cells.loc[("Bistro", "NSRR"), "ours"] == pytest.approx(mean_of(log, "psnr", ("nsrr unseen",)))
    assert cells.loc[("Bar", "Ours"), "state"] == "not run"
    assert "trained with data.scenes=atrium" in cells.loc[("Bistro", "Ours"), "setting"]
    verdicts = claims(tmp_path, "nsrd")["verdict"]
    assert (verdicts["nsrd-10"], verdicts["nsrd-16"]) == ("contradicted", "reproduced")
