"""A network that does not read the jitter, on jittered data: a warning before anything is rendered."""

import pytest

from supersampling.config import composed
from supersampling.training.check import unread_jitter


def warning(*overrides):
    composition = composed("train", ["scene=atrium", *overrides])
    return unread_jitter(composition.cfg, composition.choices["model"])


@pytest.mark.parametrize(
    "overrides",
    [
        ("model=nsrd",),
        ("model=nsrd", "task=default", "model/locate=jitter"),
        ("model=nsrd", "task=default", "model/base=jitter_aligned"),
        ("model=nsrr", "task=default"),  # its zero-upsampling places samples by the jitter
        ("model=nsrr_fast", "task=default", "model.previous=0"),
        ("model=enss_s", "budget.mlp_width=16", "model/kernel_prediction=none"),
        ("model=dlctus",),
        ("model=bicubic",),  # a baseline, as in the papers
        ("model=nsrd", "task=default", "data=files"),
    ],
    ids=" ".join,
)
def test_no_warning(overrides):
    assert warning(*overrides) is None


@pytest.mark.parametrize("more", [(), ("data=qrisp",), ("task.jitter=halton8", "model/base=none")], ids=" ".join)
def test_a_network_that_cannot_see_the_jitter(more):
    sentence = warning("model=nsrd", *(more or ("task=default",)))
    assert sentence.startswith("model=nsrd does not read the jitter, which moves the samples of task.jitter=")
    assert sentence.endswith("set task.jitter=none, or model/locate=jitter or model/base=jitter_aligned.")


def test_the_command_warns_before_it_renders(command, tmp_path):
    answer = command(
        "train", "data=files", "model=nsrd", "task=default", "+data.jitter=thesis", f"paths.root={tmp_path}"
    )
    first, *rest = [line for line in answer.err.splitlines() if line.startswith(("warning", "error"))]
    assert first.startswith("warning: model=nsrd does not read the jitter")
    assert rest[0].startswith("error")
