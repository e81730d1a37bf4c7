"""The whole command on analytic clips, with a separate store."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from mlflow.tracking import MlflowClient
from omegaconf import open_dict

from supersampling.commands import train
from supersampling.commands.advise import advise as run_advise
from supersampling.errors import UserError

ROOT = Path(__file__).resolve().parents[2]
SMALL = [
    *("budget=smoke", "trainer.enable_progress_bar=false", "workers=0", "threads=1", "size=[8,8]", "frames=2"),
    *("rungs=[1,2]", "seeds=1", "model/reproject=bilinear"),
]
Run = Callable[..., None]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("advice")


@pytest.fixture(scope="module")
def data(folder: Path, make_file: Callable[..., Path]) -> list[str]:
    paths = {split: make_file(folder, split, clips=3) for split in ("train", "val", "test")}
    return ["data=files", *(f"data.{split}=[{path}]" for split, path in paths.items())]


@pytest.fixture
def advise(folder: Path) -> Iterator[Run]:
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):

        def run(*overrides: str) -> None:
            cfg = compose(
                "advise",
                [*overrides, f"paths.root={folder}", f"tracking_uri=sqlite:///{folder}/mlflow.db"],
                return_hydra_config=True,
            )
            HydraConfig.instance().set_config(cfg)
            with open_dict(cfg):
                del cfg["hydra"]
            run_advise(cfg)

        yield run
    HydraConfig.instance().cfg = None


def runs(folder: Path, kind: str) -> list:
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    return client.search_runs(["1"], f"tags.`ss.kind` = '{kind}'")


def test_answer_is_printed_and_logged(
    advise: Run, data: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    advise("scene=analytic", *data, *SMALL)
    output = capsys.readouterr().out
    assert "Answer: accumulate=" in output
    assert "python train.py --config-dir" in output
    jobs = runs(folder, "job")
    # The plane of these clips has one depth, so that dilation is not searched: two compositions, then the better one.
    assert "dilate: none, not searched" in output
    assert 3 <= len(jobs) <= 4
    assert sum("ss.search" in run.data.tags for run in jobs) == 2
    (advice,) = runs(folder, "advice")
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    names = {artifact.path for artifact in client.list_artifacts(advice.info.run_id)}
    assert {"search.json", "contributions.json", "reasons.json", "summary.json"} <= names
    assert {"buffers.json", "facts.json", "advice.yaml"} <= names


def test_repeated_search_trains_nothing_and_gives_the_same_answer(advise: Run, data: list[str], folder: Path) -> None:
    path = folder / "outputs" / "advice" / "experiment" / "analytic_dlctus.yaml"
    before, jobs = path.read_text(), len(runs(folder, "job"))
    advise("scene=analytic", *data, *SMALL)
    assert path.read_text() == before
    assert len(runs(folder, "job")) == jobs


def test_answer_is_an_experiment_of_train(advise: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The experiment is the training of the last round, which train.py finds; another seed is a new training."""
    out = folder / "outputs" / "advice"
    content = yaml.safe_load((out / "experiment" / "analytic_dlctus.yaml").read_text())
    assert content["scene"] == "analytic"
    paths = [
        f"paths.root={folder}",
        f"tracking_uri=sqlite:///{folder}/mlflow.db",
        f"hydra.searchpath=[file://{out},file://{ROOT}]",
    ]
    before = len(runs(folder, "job"))
    for seed, more in ((0, 0), (5, 1)):
        overrides = [*paths, "experiment=analytic_dlctus", f"seed={seed}", "threads=1", "workers=0", "baselines=[]"]
        overrides += ["metrics=fast", "trainer.enable_progress_bar=false"]
        cfg = compose("train", overrides, return_hydra_config=True)
        HydraConfig.instance().set_config(cfg)
        with open_dict(cfg):
            del cfg["hydra"]
        monkeypatch.setattr(train, "score_sanity", lambda *a: None)
        train.train(cfg)
        assert len(runs(folder, "job")) == before + more


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["margin=0"], "Invalid margin=0: use a positive number"),
        (["margin=-1"], "Invalid margin=-1"),
        (["margin=100"], "Invalid margin=100: use a number of dB below 100"),
        (["margin=much"], "Invalid margin=much"),
        (["rungs=[2,1]"], "Invalid rungs=[2, 1]: list epochs from the shortest"),
        (["rungs=[]"], "Invalid rungs=[]: use a list of whole numbers"),
        (["seeds=[1,1,1]"], "Invalid seeds=[1, 1, 1]: use one number of seeds per rung"),
        (["steps=3"], "Invalid steps=3: the first round of 2 compositions takes 4"),
        (["steps=0"], "Invalid steps=0"),
        (["search=all"], "Invalid search=all: use halving or optuna"),
        (["size=[3]"], "Invalid size=[3]"),
        (["walk=1"], "has 2 compositions, more than walk=1"),
        (["budget.crop=4096"], "None of the 2 compositions could be trained"),
        (["budget.crop=2"], "Invalid budget.crop=2"),
    ],
)
def test_mistakes_are_one_sentence(advise: Run, data: list[str], overrides: list[str], message: str) -> None:
    replaced = {o.split("=")[0] for o in overrides}
    with pytest.raises(UserError, match=message.replace("[", r"\[")):
        advise("scene=analytic", *data, *(o for o in SMALL if o.split("=")[0] not in replaced), *overrides)


def test_unknown_scene(advise: Run) -> None:
    with pytest.raises(Exception, match="Unknown scene atlantis") as error:
        advise("scene=atlantis", *SMALL)
    assert isinstance(error.value, UserError) or isinstance(error.value.__cause__, UserError)


@pytest.mark.slow
def test_optuna_proposes_and_continues(advise: Run, data: list[str], folder: Path) -> None:
    pytest.importorskip("optuna")
    import optuna

    more = ["search=optuna", "trials=3", "out=" + str(folder / "optuna")]
    advise("scene=analytic", *data, *SMALL, *more)
    jobs = len(runs(folder, "job"))
    advise("scene=analytic", *data, *SMALL, *more)  # all trials exist
    assert len(runs(folder, "job")) == jobs
    (name,) = {
        s.study_name for s in optuna.get_all_study_summaries(f"sqlite:///{folder}/optuna/analytic_dlctus.optuna.db")
    }
    study = optuna.load_study(study_name=name, storage=f"sqlite:///{folder}/optuna/analytic_dlctus.optuna.db")
    assert len(study.trials) == 3
    assert all(len(trial.values) == 2 for trial in study.trials)


@pytest.mark.slow
def test_printed_command_reads_the_answer(advise: Run, data: list[str], folder: Path) -> None:
    advise("scene=analytic", *data, *SMALL)
    out = folder / "outputs" / "advice"
    command = [sys.executable, "train.py", "--config-dir", str(out), "experiment=analytic_dlctus", "--cfg", "job"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=True)
    assert yaml.safe_load(done.stdout)["scene"] == "analytic"
