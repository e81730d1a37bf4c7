"""Random command lines, seeded: status 0 or 2, one line on status 2, and never a stack trace.

The commands themselves are replaced by one that makes the configured parts. ``FUZZ_SECONDS`` sets the duration.
"""

import os
import random
import traceback
from importlib import import_module

import pytest
from fuzzing import trials
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling.commands.entry import COMMANDS
from supersampling.config import composed, group_options
from supersampling.resources import resources

SEED = int(os.environ.get("FUZZ_SEED", "0"))
CHARACTERS = "abz019 =,.:;-_+~@$%!?#*|&/\\'\"()[]{}<>\t\u00e9\u2013\u4f60"
VALUES = (
    *("0", "1", "-1", "1.5", "1e3", "1e400", "nan", "inf", "-inf", "null", "true", "False", "", "''", '""', "08"),
    *("1_000", "999999999999999999999", "[]", "{}", "[1,2]", "[a,[b]]", "{a:1}", "{a:{b:[1]}}", "a,b", "1,2"),
    *("range(3)", "int(1)", "range(0,9,0)", "choice(1,2)", "choice()", "glob(*)", "interval(0,1)", "str(1)", "foo(1)"),
    *("sort(2,1)", "tag(a,1)", "${seed}", "${nothing}", "${oc.env:NOTHING}", "${oc.env:HOME}", "${.a}", "${..}", "${"),
    *("}", "\\${a}", "${cores:}", "a=b", "My Model (1).glb", "~/x", "out/epoch=9-step=99.ckpt", "'a,b.h5'", '"a'),
    *("a\\", "=1", "x" * 5000, "é", "你", "${product:a,2}", "${installed_scenes:}", "_target_", "{_target_:os.getcwd}"),
    *("???", "[???]", "atrium", "none"),
)
FLAGS = (
    *(("--cfg", "job"), ("--cfg", "all", "--resolve"), ("--cfg", "hydra", "-p", "hydra.run"), ("-m",), ("--multi",)),
    *(("--info", "defaults"), ("--info",), ("--package", "x"), ("--resolve",), ("--run",), ("-c",), ("-x",), ("--",)),
    *(("--cfg", "job", "-p", "model"), ("-sc", "install=bash"), ("--config-name", "job"), ("-cd", "."), ("--version",)),
)
HYDRA = ("run.dir", "sweep.dir", "mode", "job.num", "verbose", "sweeper.params", "sweeper.max_batch_size", "callbacks")
PARTS = ("model", "loss", "protocol", "augment", "pick")


def make_parts(cfg: DictConfig) -> None:
    """Make the parts of a configuration that are cheap to make."""
    for key in PARTS:
        if key in cfg:
            instantiate(cfg[key])


def keys_of(name: str) -> list[str]:
    """Return the keys of a command and its groups."""
    cfg = composed(name, []).cfg
    folders = [path for path in (resources() / "conf").rglob("*") if path.is_dir()]
    groups = [str(path.relative_to(resources() / "conf")) for path in folders]
    return [*groups, *groups, *(f"hydra.{key}" for key in HYDRA), *_flat(cfg, "")]


def _flat(cfg: DictConfig, prefix: str) -> list[str]:
    keys = []
    for key, value in cfg.items_ex(resolve=False):
        keys.append(f"{prefix}{key}")
        if isinstance(value, DictConfig) and not OmegaConf.is_interpolation(cfg, key) and value is not None:
            keys += _flat(value, f"{prefix}{key}.")
    return keys


def mutate(draw: random.Random, word: str) -> str:
    """Return a word with some characters inserted, dropped or repeated."""
    for _ in range(draw.randint(1, 3)):
        place = draw.randrange(len(word) + 1)
        word = draw.choice(
            [
                word[:place] + draw.choice(CHARACTERS) + word[place:],
                word[:place] + word[place + 1 :],
                word[:place] + word[place : place + 3] * 2 + word[place + 3 :],
            ]
        )
    return word


def override(draw: random.Random, keys: list[str]) -> str:
    """Return a setting with a value of its group, of the list, or of random characters."""
    key = draw.choice(keys)
    values = [*group_options(key), *draw.sample(VALUES, 3), "".join(draw.choices(CHARACTERS, k=draw.randint(0, 6)))]
    prefix = draw.choice(["", "", "", "", "+", "++", "~"])
    word = f"{prefix}{key}={draw.choice(values)}"
    if prefix == "~" and draw.random() < 0.5:
        word = f"~{key}"
    return mutate(draw, word) if draw.random() < 0.25 else word


def line_of(draw: random.Random, keys: list[str]) -> list[str]:
    words = [override(draw, keys) for _ in range(draw.choice([1, 1, 2, 3]))]
    if draw.random() < 0.25:
        place = draw.randrange(len(words) + 1)
        words[place:place] = draw.choice(FLAGS)
    return words


@pytest.mark.slow
def test_no_command_line_ends_in_a_stack_trace(command, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SUPERSAMPLING_ROOT", str(tmp_path))
    draw = random.Random(SEED)
    keys = {name: keys_of(name) for name in COMMANDS}
    for name in COMMANDS:
        monkeypatch.setattr(import_module(f"supersampling.commands.{name}"), name, make_parts)
    failures = []
    for _ in trials():
        name = draw.choice(list(COMMANDS))
        words = line_of(draw, keys[name])
        try:
            answer = command(name, *words)
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            failures.append((name, words, repr(error)[:300], f"{place.filename}:{place.lineno}"))
            continue
        errors = [line for line in answer.text.splitlines() if line.startswith("error: ")]
        wrong = answer.status not in (0, 2) or (answer.status == 2 and len(errors) != 1)
        if wrong or "Traceback" in answer.text:
            failures.append((name, words, answer.status, answer.text[-600:]))
    report = "\n".join(map(repr, failures))
    (tmp_path / "failures.txt").write_text(report)
    assert not failures, f"FUZZ_SEED={SEED}, {len(failures)} lines, in {tmp_path}/failures.txt:\n{report[:6000]}"
