"""Command lines: every flag of Hydra in every command, paths with any characters, and one sentence per mistake."""

import re
import shlex
from pathlib import Path

import pytest
import yaml
from answers import ROOT

from supersampling.commands.entry import COMMANDS
from supersampling.commands.quoting import quote_text
from supersampling.scenes.load import installed_scenes

SHOWN = [
    ("--cfg", "job"),
    ("--cfg", "job", "--resolve"),
    ("--cfg", "hydra"),
    ("--cfg", "hydra", "--resolve"),
    ("--cfg", "all"),
    ("--cfg", "all", "--resolve"),
    ("--cfg", "all", "--resolve", "--package", "paths"),
    ("--cfg", "job", "-p", "paths.root"),
    *(("--info", *kind) for kind in ((), ("all",), ("config",), ("defaults",), ("defaults-tree",))),
    *(("--info", kind) for kind in ("plugins", "searchpath")),
    *(("-sc", f"{action}={shell}") for action in ("install", "uninstall") for shell in ("bash", "zsh", "fish")),
    *(("--help",), ("--help", "--resolve"), ("--hydra-help",), ("--version",)),
]


@pytest.mark.parametrize("name", COMMANDS)
def test_row_2_a_configuration_is_shown_with_its_references_resolved(name, command, row, tmp_path):
    root = f"paths.root={tmp_path}"
    whole, job = (command(name, "--cfg", kind, "--resolve", root) for kind in ("all", "job"))
    assert (whole.status, job.status) == (0, 0)
    assert "${" not in whole.text + job.text
    shown = yaml.safe_load(job.text)
    assert shown["paths"]["data"] == f"{tmp_path}/datasets"
    assert shown.get("scene", installed_scenes()) == installed_scenes()
    assert yaml.safe_load(whole.text).items() >= shown.items()
    row("2", "--cfg job --resolve failed on a resolver", "the resolved configuration, in all 14 commands")


def test_the_folder_of_a_sweep_follows_the_project_s(command, tmp_path):
    answer = command("count", "--cfg", "hydra", "--resolve", f"paths.root={tmp_path}")
    assert yaml.safe_load(answer.text)["hydra"]["sweep"]["dir"] == f"{tmp_path}/outputs/multirun"


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("flags", SHOWN, ids=" ".join)
def test_every_flag_that_shows_something_works_in_every_command(flags, name, command):
    answer = command(name, *flags)
    assert answer.status == 0
    assert answer.text.strip()


@pytest.mark.parametrize(
    "flags", [("--cfg", "job", "-p", "loss"), ("--info", "defaults-tree"), ("-sc", "install=fish")]
)
def test_flags_of_train(flags, command):
    assert "spatiotemporal\n" in (text := command("train", *flags).text).lower() or "hydra_fish_completion" in text


@pytest.mark.parametrize("order", [("-m", "seed=0,1", "{}"), ("seed=0,1", "-m", "{}"), ("seed=0,1", "{}", "--multi")])
def test_flags_may_stand_between_the_settings(order, command, tmp_path):
    """The sweep's second job has a number out of range: the sentence shows that all words were read."""
    words = [word.format("budget.epochs=1,0") for word in order]
    answer = command("train", *words, f"paths.root={tmp_path}")
    assert answer.status == 2
    assert "seed=0 budget.epochs=0" in answer.text
    assert answer.last_line.endswith(
        "Invalid budget.epochs=0: use a whole number between 1 and 1e+06. No job was started."
    )
    assert not (tmp_path / "outputs").exists()


FLAGS = [
    (("--cfg", "jobs"), "invalid choice: 'jobs' (choose from"),
    (("--cfg",), "--cfg/-c: expected one argument"),
    (("--cfg", "job", "--package", "losses"), "losses is not set: see python train.py --cfg job"),
    (("--package", "loss"), "--package=loss shows a part of a configuration: add --cfg job."),
    (("--resolve",), "--resolve shows a configuration with its interpolations resolved: add --cfg job."),
    (("--cfg", "job", "-m"), "--multirun and --cfg exclude each other: use one of them."),
    (("--loss.theta=0.1",), "Unknown flag --loss.theta=0.1: write settings without dashes, loss.theta=0.1."),
    (("--frobnicate",), "Unknown flag --frobnicate: train.py --hydra-help lists the flags"),
    (("\u2013m", "seed=0,1"), "begins with a dash that is no hyphen: write -m."),
    (("\u2014cfg", "job"), "begins with a dash that is no hyphen: write --cfg."),
    (("-sc",), "--shell-completion needs a shell: use train.py -sc install=bash"),
    (("-sc", "install=tcsh"), "--shell-completion needs a shell"),
    (("--config-name", "nothing"), "There is no configuration nothing.yaml"),
    (("--config-name", "report"), "--config-name=report has no augment, baselines"),
    (("--config-dir", "/nowhere"), "--config-dir=/nowhere is no folder"),
    (("--config-path", "nowhere"), "--config-path=nowhere is no folder"),
    (("--experimental-rerun", "nothing.pickle"), "--experimental-rerun=nothing.pickle not found"),
]


@pytest.mark.parametrize(
    ("words", "sentence"), FLAGS, ids=lambda value: " ".join(value) if isinstance(value, tuple) else ""
)
def test_a_wrong_flag_is_one_sentence(words, sentence, command):
    answer = command("train", *words)
    assert (answer.status, answer.text.count("\n")) == (2, 1)
    assert sentence in answer.text


PARTS = [
    ("train", ["+model/extract=learned"], "+model/extract=learned cannot be used"),
    ("train", ["model._target_=a.b"], "model._target_=a.b cannot be used (Error loading 'a.b')"),
    ("evaluate", ["--multi", "model.initialise._target_=0*"], "model.initialise._target_=0* cannot be used"),
    ("train", ["loss={_target_:os.getcwd}"], "loss={_target_:os.getcwd} cannot be used"),
    ("advise", ["++protocol._target_=???"], "protocol._target_ has no value (???): set it to one."),
    ("count", ["model._target_=\\"], "model._target_=\\ cannot be used"),
]


@pytest.mark.parametrize(("name", "words", "sentence"), PARTS, ids=lambda value: str(value)[:30])
def test_a_part_that_cannot_be_made_is_one_sentence(name, words, sentence, command, tmp_path):
    answer = command(name, *words, f"paths.root={tmp_path}", "data=smoke", "scene=atrium")
    assert answer.status == 2
    assert f"\nerror: {sentence}" in f"\n{answer.text}"
    assert "Traceback" not in answer.text


def test_row_37_a_path_needs_no_second_quotes(command, row, tmp_path):
    answer = command("evaluate", "checkpoint=out/epoch=9-step=99.ckpt", f"paths.root={tmp_path}")
    assert answer.status == 2
    assert "out/epoch=9-step=99.ckpt" in answer.last_line
    assert "mismatched" not in answer.text
    row("37", "= in the path of a checkpoint", f"read as typed: {answer.last_line}")
    answer = command("render", "scene=gltf", "path=My Model (1).glb", f"paths.root={tmp_path}")
    assert answer.status == 2
    assert "My Model (1).glb" in answer.last_line
    row("37", "brackets in the path of a model", f"read as typed: {answer.last_line}")


NAMES = [
    *("epoch=9-step=99", "My Model (1)", "a,b", "[a]", "{a}#!;&", "é ü", "a'b\"c", "1e3", "null"),
    *("~a ", "x: y", "\\${x}", "a\\b\\", "true"),
]


@pytest.mark.parametrize("name", NAMES)
def test_an_existing_file_of_any_name_is_read(name, command, files, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path(name).symlink_to(files["test"])
    items = "x.h5" if "," in name or name == "null" else f"x.h5,{name}"  # null is the word for no file: write ./null
    answer = command("show", f"file={name}", "data=files", f"data.test=[{items}]", "--cfg", "job", "--resolve")
    shown = yaml.safe_load(answer.text)
    assert shown["file"] == (None if name == "null" else name)
    assert shown["data"]["test"][1:] == ([name.strip()] if items != "x.h5" else [])


def test_a_home_folder_is_expanded(command, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    for word in ("out=~/x.onnx", "out='~/x.onnx'"):
        assert command("export", word, "--cfg", "job", "-p", "out").text == f"{tmp_path}/x.onnx\n"
    answer = command("train", "data=files", "data.test=[~/E.h5]", "--cfg", "job", "-p", "data.test.0")
    assert answer.text == f"{tmp_path}/E.h5\n"


def documented():
    """Return the commands of the section on paths and names."""
    page = (ROOT / "docs" / "train.md").read_text().partition("## Type paths and names")[2].partition("\n## ")[0]
    return re.findall(r"`python (.*)` \|", page)


@pytest.mark.parametrize("line", documented())
def test_the_documented_words_are_read_as_typed(line, command):
    name, *words = shlex.split(line)
    if "-m" in words:
        assert quote_text("evaluate", words[1], True) == words[1]
        return
    answer = command(name.removesuffix(".py"), *words, "--cfg", "job", "--resolve")
    key, _, value = words[-1].partition("=")
    shown = yaml.safe_load(answer.text)
    for part in key.split("."):
        shown = shown[part]
    assert shown == {"a\\${b}.glb": "a${b}.glb"}.get(value, yaml.safe_load(value))


MISTAKES = [
    ("loss.theta==1", "loss.theta==1 has two equals signs: write loss.theta=1."),
    ("seed=1,", "seed=1, has a comma too many: write seed=1."),
    ("seed=0,1", "seed=0,1 holds several values: add -m to run a job for each"),
    ("seed=range(0,3)", "seed=range(0,3) runs several jobs: add -m."),
    ("seed = 1", "seed = 1 is no setting: write key=value, without spaces around the equals sign."),
    ("model", "model is no setting: write model=OPTION, one of bicubic, bilinear"),
    ("dlctus", "dlctus is no setting: write model=dlctus"),
    ("model:dlctus", "model:dlctus is no setting: write model=dlctus."),
    ("", "An empty word is no setting"),
    ("a..b=1", "a..b=1 is no setting: a..b is no key"),
    ("model=null", "Unknown option model=null: use bicubic"),
    ("model={a:1}", "model is a group without this setting: write model=OPTION"),
    ("~model", "model has no option: write model=OPTION."),
    ("~loss", "~loss deletes a setting that the command needs: leave it out."),
    ("+seed=1", "seed exists: write seed=VALUE, without +."),
    ("+loss=l1", "loss has an option: write loss=OPTION, without +."),
    ("Loss.theta=1", "train.py has no setting Loss.theta: write loss.theta"),
    ("data.test.0=x", "train.py has no setting data.test.0: use one of the settings of data.test (clips, frames"),
    ("seed=${nothing}", "seed=${nothing} cannot be resolved (Interpolation key 'nothing' not found)"),
    ("seed=${oc.env:NO_SUCH_VARIABLE}", "Environment variable 'NO_SUCH_VARIABLE' not found"),
    ("seed=${seed}", "seed=${seed} cannot be resolved (Recursive interpolation detected)"),
    ("hydra/launcher=joblib", "Unknown option hydra/launcher=joblib: use basic."),
    ("hydra.frob=1", "Hydra has no setting hydra.frob"),
    ("hydra.run.dir=/proc/x", "A folder cannot be used"),
    ("hydra.mode=FOO", "Invalid value 'FOO', expected one of [RUN, MULTIRUN]"),
    ("+loss.gamma=1", "+loss.gamma=1 cannot be used"),
    ("~model/initialise", "~model/initialise cannot be used"),
]


@pytest.mark.parametrize(("word", "sentence"), MISTAKES)
def test_a_wrong_setting_is_one_sentence(word, sentence, command, data):
    answer = command("train", *(data if "loss" in word else data[-1:]), word)
    assert answer.status == 2
    assert sentence in answer.last_line
    assert answer.last_line.startswith("error: ")
    assert answer.text.count("\n") == 1


def test_the_word_that_a_sentence_prints_can_be_typed(command):
    answer = command("train", "task.jitter=a(1)b", "--cfg", "job")
    word = shlex.split(answer.last_line.rpartition("if it is text, ")[2].removesuffix("."))
    assert word == ['task.jitter="a(1)b"']
    assert command("train", *word, "--cfg", "job", "-p", "task.jitter").text == "a(1)b\n"


SWEEPS = [
    (("loss.theta=0.1,7",), "error: loss.theta=7: Invalid loss.theta=7"),
    (("model=glob(x*)",), "runs no job: a list or pattern of it is empty."),
    (("seed=range(0,3,0)",), "range() arg 3 must not be zero"),
    (("loss.theta=interval(0,1)",), "interval() needs another sweeper"),
    (("sweeps=laptop", "sweeps=nsrr_table9"), "sets sweeps twice: write sweeps=laptop,nsrr_table9."),
]


@pytest.mark.parametrize(("words", "sentence"), SWEEPS)
def test_a_sweep_with_a_mistake_starts_no_job(words, sentence, command, tmp_path):
    answer = command("train", "-m", *words, f"paths.root={tmp_path}")
    assert answer.status == 2
    assert sentence in answer.last_line
    assert answer.text.count("\n") == 1
    assert not list(tmp_path.iterdir())
