"""Wrong switches: one sentence that names the right one, without rendering anything."""

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra

from supersampling.commands.entry import COMMANDS
from supersampling.commands.explanation import explanation
from supersampling.commands.overrides import MOVED, check_overrides, with_additions
from supersampling.errors import UserError
from supersampling.resources import resources


def answer(command: str, *overrides: str) -> str:
    """Return the sentence that a command line gets."""
    try:
        check_overrides(command, overrides)
    except UserError as error:
        return str(error)
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(resources() / "conf"), version_base="1.3"):
        try:
            compose(command, list(overrides))
        except Exception as error:
            return str(explanation(command, overrides, error))
    return ""


CASES = [
    (("train", "model.warp_at=low"), "write model/warp_at=low, with a slash"),
    (("train", "model=nsrr", "model.warp_at=low"), "write model/warp_at=low"),
    (("train", "model=nsrr", "model/accumulate=none"), "Model nsrr has no slot accumulate: set model=dlctus"),
    (
        ("train", "model=dlctus", "model/history=none"),
        "own slots (reproject, dilate, pad, accumulate, confine, initialise)",
    ),
    (("train", "experiment=enss", "model/accumulate=none"), "Model enss_m has no slot accumulate"),
    (("train", "model/frobnicate=none"), "Model dlctus has no slot frobnicate: use one of its own slots"),
    (("train", "model=nsr"), "Unknown option model=nsr: use bicubic, bilinear"),
    (("train", "model/reproject=bilinear,cubic"), "Unknown option model/reproject=cubic: use bicubic5"),
    (("train", "experiment=enss_table3/raftt"), "enss_table3=raftt: use baseline"),
    (("train", "loss=l1", "loss.theta=0.5"), "loss=l1 has no setting theta: set loss=spatiotemporal"),
    (("train", "model=nsrr", "loss.theta=0.5"), "loss=nsrr has no setting theta: set loss=spatiotemporal"),
    (("train", "experiment=[dlctus,dlctus/xiao]"), "not have: write experiment=dlctus/xiao_published"),
    (("train", "experiment=dlctus", "model=nsrd"), "experiment=dlctus sets model/confine, which the other model"),
    (("train", "loss.thetta=0.5"), "loss=spatiotemporal has no setting thetta: use one of its own settings (theta)"),
    (("train", "budget.epoch=3"), "budget=demo has no setting epoch"),
    (("train", "lr=3"), "train.py has no setting lr"),
    (("report", "model/warp_at=low"), "report.py has no setting model/warp_at, as it has no model"),
    (("evaluate", "loss=l1"), "evaluate.py has no setting loss"),
    (("train", "logger.tracking_uri=x"), "write tracking_uri=x"),
    (("render", "import=qrisp"), "write import_capture.py layout=qrisp"),
    (("benchmark", "pick.ms=3"), "write pick.py ms=3"),
    (("train", "scene=[a"), "scene=[a cannot be read"),
]


@pytest.mark.parametrize(("line", "part"), CASES, ids=lambda value: " ".join(value) if isinstance(value, tuple) else "")
def test_a_wrong_switch_names_the_right_one(line, part):
    sentence = answer(*line)
    assert part in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence


@pytest.mark.parametrize(
    "line",
    [
        ("train", "model=nsrr", "model/warp_at=low", "model.previous=2"),
        ("train", "model=dlctus", "loss.theta=0.5", "data.train.clips=3", "+extra=1"),
        (
            "train",
            "data=files",
            "data.train=[a.h5]",
            "budget.scheduler={_target_: torch.optim.lr_scheduler.ConstantLR}",
        ),
        ("render", "scene=[atrium,foundry]", "buffers=[color]"),
        ("compare", "a='dlctus loss.theta=0.1'", "b=tus"),
    ],
)
def test_a_right_line_gets_no_answer(line):
    assert answer(*line) == ""


def test_what_moved_is_gone():
    for key in MOVED:
        for command in COMMANDS:
            if "." in key:
                assert answer(command, f"{key}=1")


@pytest.mark.parametrize("flag", [["--config-dir=FOLDER"], ["--config-path=FOLDER"], ["hydra.searchpath=[FOLDER]"]])
def test_options_of_a_folder_of_the_user_s_own_are_left_to_hydra(flag):
    with pytest.raises(UserError, match="Unknown option experiment=mine"):
        check_overrides("train", ["experiment=mine"])
    check_overrides("train", [*flag, "experiment=mine", "model=dlctus"])


@pytest.mark.parametrize("word", ["trainer.max_time=00:01:00:00", "+trainer.max_time=00:01:00:00"])
def test_arguments_of_lightning_are_set_or_added(word):
    assert with_additions("train", [word, "-m", "trainer=default"]) == [
        "++trainer.max_time=00:01:00:00", "-m", "trainer=default"
    ]  # fmt: skip
    assert with_additions("train", ["++trainer.precision=bf16-mixed"]) == ["++trainer.precision=bf16-mixed"]
    assert with_additions("evaluate", [word]) == [word]
