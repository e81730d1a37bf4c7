"""Text on a command line: Hydra reads exactly what was typed."""

import os
import random

import pytest
from omegaconf import OmegaConf

from supersampling.commands.quoting import parse, quote, quote_text, shell_word, split


def read(word: str) -> object:
    """Return the value of a word as Hydra and OmegaConf read it."""
    override = parse(word.partition("=")[2])
    return OmegaConf.create({"key": override.value()}).key


def test_any_text_survives_its_quotes():
    draw = random.Random(0)
    for _ in range(400):
        text = "".join(draw.choices("ab1 =,[]{}()'\"\\${}#!~:;|&*?é%@+-./", k=draw.randint(1, 8)))
        assert read(f"key={quote(text)}") == text


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("checkpoint=a=1.ckpt", "a=1.ckpt"),
        ("run=3e7", "3e7"),
        ("name=true", "true"),
        ("name=1_000", "1_000"),
        ("name=null", None),
        ("name='a b'", "a b"),
        ("path=[a].glb", "[a].glb"),
        ("path=a\\ b", "a b"),
        ("data.test=a.h5", ["a.h5"]),
        ("data.test=a.h5,b.h5", ["a.h5", "b.h5"]),
        ("data.test=[x=1/E.h5,'a,b.h5']", ["x=1/E.h5", "a,b.h5"]),
        ("data.test=[]", []),
        ("models=tus", ["tus"]),
        ("models=[dlctus model/reproject=bilinear,tus]", ["dlctus model/reproject=bilinear", "tus"]),
    ],
)
def test_text_is_read_as_typed(word, value):
    assert read(quote_text("evaluate", word, False)) == value


@pytest.mark.parametrize(
    "word",
    ["seed=1e3", "seed=range(1,3)", "data.test=${data.train}", "data.test={clips:1}", "out=${paths.root}/x", "~path"],
)
def test_other_words_stay(word):
    assert quote_text("evaluate", word, False) == word


def test_commas_separate_the_values_of_a_sweep():
    assert quote_text("evaluate", "checkpoint=a=1.ckpt,b.ckpt", True) == 'checkpoint="a=1.ckpt",b.ckpt'
    assert quote_text("evaluate", "run=3e7,4e7", True) == 'run="3e7","4e7"'
    assert quote_text("train", "data.test=[a=1.h5],[b.h5]", True) == 'data.test=["a=1.h5"],[b.h5]'
    assert quote_text("train", "data.test=a.h5,b.h5", True) == "data.test=[a.h5],[b.h5]"


def test_an_existing_file_is_read_under_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a,b", "${x}", "u=1"):
        (tmp_path / name).touch()
    assert read(quote_text("render", "path=a,b", False)) == "a,b"
    assert read(quote_text("render", "path=${x}", False)) == "${x}"
    assert read(quote_text("train", "+any.key=u=1", False)) == "u=1"
    assert quote_text("train", "+any.key=v=1", False) == "+any.key=v=1"
    assert quote_text("render", "path=c,d", False) == "path=c,d"  # Hydra's question whether this is a sweep


def test_frames_is_a_path_for_evaluate_only():
    assert quote_text("evaluate", "frames=7", False) == 'frames="7"'
    assert quote_text("benchmark", "frames=7", False) == "frames=7"


def test_the_shell_word_is_one_word():
    assert shell_word("path", "a'b (1)") == """'path="a'"'"'b (1)"'"""
    assert os.path.basename(shell_word("path", "a")) == "'path=\"a\"'"


def test_commas_in_quotes_and_brackets_do_not_split():
    assert split("a,'b,c',[d,e],f(g,h),\\,i") == ["a", "'b,c'", "[d,e]", "f(g,h)", "\\,i"]
