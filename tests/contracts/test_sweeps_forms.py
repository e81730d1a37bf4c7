"""The sweeps of NSRR and ENSS: those that hold a table of `test_ablations` have its rows, in any form of the method."""

from functools import cache

import pytest
from hydra import compose, initialize_config_dir
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from model_cases import CONF, stems
from omegaconf import OmegaConf
from test_ablations import TABLES

# Rows that a sweep leaves out: no row of the paper, or one that is tested on other scenes than it is trained on.
LEFT_OUT = {"enss_table3": {f"(-{n}) training scenes" for n in (2, 5, 8)} | {"(-) MVs, (+) TV-L1"}}
STRICT = [name for name in stems("../sweeps") if name in TABLES and name.startswith(("nsrr_", "enss_"))]


def composed(*overrides):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("train", [*overrides, "budget=laptop"], return_hydra_config=True)


@cache
def jobs(*command):
    """``{its overrides: what they compose to}`` of each job that Hydra's basic sweeper makes of a command."""
    params = composed(*command).hydra.sweeper.params
    words = [f"{key}={value}" for key, value in params.items()]
    (rows,) = BasicSweeper.split_arguments(OverridesParser.create().parse_overrides(words), None)
    return {" ".join(job): composed(*command, *job) for job in rows}


def program(cfg):
    """What a row is, whatever its data and budget."""
    return repr([OmegaConf.to_container(cfg[key], resolve=True) for key in ("model", "loss", "task")])


@pytest.mark.parametrize("name", STRICT)
def test_a_sweep_s_jobs_are_the_table_s_rows(name):
    command, rows = TABLES[name]
    added = [more for row, more in rows.items() if row not in LEFT_OUT.get(name, ())]
    expected = {program(composed(*f"{command} {more}".split())) for more in added}
    assert {program(cfg) for cfg in jobs(f"sweeps={name}").values()} == expected


@pytest.mark.parametrize("name", [name for name in stems("../sweeps") if name.startswith("nsrr_")])
def test_the_rows_of_nsrr_go_with_another_form_of_it(name):
    """What ``experiment=laptop/nsrr`` sets stays in every job, but for what the row itself is about."""
    swept = set(composed(f"sweeps={name}").hydra.sweeper.params)
    for cfg in jobs(f"sweeps={name}", "experiment=laptop/nsrr").values():
        choices = cfg.hydra.runtime.choices
        assert (choices["loss"], choices["model/base"], choices["task"]) == ("l1", "jitter_aligned", "default")
        assert "model/colour_space" in swept or choices["model/colour_space"] == "rgb"
    other = jobs(f"sweeps={name}", "experiment=laptop/nsrr").values()
    assert len({program(cfg) for cfg in other}) == len(jobs(f"sweeps={name}"))
