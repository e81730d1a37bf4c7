"""A paper's sweeps agree: one budget and one data set, so that one report has all of its tables; what needs weights of
another program says which file, and has a form without them."""

import re
from functools import cache

import pytest
from model_cases import CONF
from omegaconf import OmegaConf
from test_sweeps import SWEEPS, jobs_of

from supersampling.config import composed
from supersampling.reporting.settings import budget_family
from supersampling.scenes.built_in import BUILT_IN

FILES = {"vgg": "vgg16-397923af.pth", "raft": "raft_large_C_T_SKHT_V2-ff5fadd5.pth"}
LPIPS = "alexnet-owt-7be5be79.pth"
WITH_LPIPS = {"nsrd_table1", "nsrd_table2", "nsrd_figure6", "enss_table2", "enss_table2_xiao", "enss_table3"}
# The rows of this sweep that need weights are about them.
ABOUT_WEIGHTS = {"enss_table3"}


def text_of(name):
    return (CONF.parent / "sweeps" / f"{name}.yaml").read_text()


@cache
def composition_of(*job):
    return composed("train", job)


def files_of(job):
    """The files of weights that a job's training reads."""
    cfg = composition_of(*job).cfg
    needs = {"vgg"} if OmegaConf.select(cfg, "loss.weights.perceptual") else set()
    needs |= {"raft"} if str(OmegaConf.select(cfg, "model.flow._target_")).endswith("RAFT") else set()
    return {FILES[name] for name in needs}


@pytest.mark.parametrize("name", SWEEPS)
def test_its_jobs_fill_one_report(name):
    for job in jobs_of(name):
        composition = composition_of(*job)
        assert composition.choices["data"] == "laptop"
        assert budget_family(composition.choices["budget"]) == "laptop"
        assert composition.choices["augment"] == "full"
        assert composition.choices["pick"] == "edges"
        if not any(word.startswith("scene=") for word in job):
            assert set(composition.cfg.scene) == set(BUILT_IN)


@pytest.mark.parametrize("name", SWEEPS)
def test_what_needs_weights_names_the_file_and_a_form_without(name):
    needed = set().union(*(files_of(job) for job in jobs_of(name)))
    assert {file for file in FILES.values() if file in text_of(name)} == needed
    assert (LPIPS in text_of(name)) == (name in WITH_LPIPS)
    if needed and name not in ABOUT_WEIGHTS:
        form = re.search(r"Without it[^:]*:\s(?:# )?(experiment=.*)", text_of(name))
        jobs = jobs_of(name, *form[1].split())
        assert jobs
        assert not set().union(*(files_of(job) for job in jobs))
