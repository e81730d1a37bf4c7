"""Every sweep: its jobs compose, are different jobs, take the laptop's form of a method, and are the rows of their
table."""

import pytest
from hydra import compose, initialize_config_dir
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from model_cases import CONF, stems
from omegaconf import OmegaConf
from test_ablations import DATA_SETS, TABLES
from test_ablations import composed as of_a_row

SWEEPS = stems("../sweeps")
# Sweeps that run another table's rows too, and rows that no sweep runs: the paper has none of them, or exchanges the
# stage in the test (sections 5.5.1 and 5.5.2 of the thesis).
EXTRA = {"dlctus_table2": ("dlctus_table2_xiao",)}
LEFT_OUT = (
    ("nsrd_table5_nsrr", "as published"),
    ("nsrd_table5_nsrr", "demodulation alone"),
    ("nsrd_table5_nsrr", "radiance, all material buffers"),
    *(("dlctus_table13", f"{option}, {key}") for option in ("bilinear", "bicubic5") for key in DATA_SETS),
    *(("dlctus_table14", f"closest, {key}") for key in DATA_SETS),
)


def composed(*overrides):
    GlobalHydra.instance().clear()
    scene = [] if any(word.startswith("scene=") for word in overrides) else ["scene=atrium"]
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("train", [*scene, *overrides])


def jobs_of(sweep: str, *overrides: str) -> list[list[str]]:
    """What ``train.py -m sweeps=<sweep> <overrides>`` runs: each job's overrides, less ``hydra.*``."""
    params = OmegaConf.load(CONF.parent / "sweeps" / f"{sweep}.yaml").hydra.sweeper.params
    words = [*(f"{key}={values}" for key, values in params.items()), f"sweeps={sweep}", *overrides]
    (jobs,) = BasicSweeper.split_arguments(OverridesParser.create().parse_overrides(words), None)
    return jobs


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_s_jobs_compose_and_are_different_jobs(name):
    jobs = jobs_of(name, "budget=laptop")
    seen = {OmegaConf.to_yaml(composed(*job), resolve=False) for job in jobs}
    assert len(seen) == len(jobs) > 0


# What the comments of sweeps/ say for the laptop, and how many jobs it makes.
IN_MINUTES = {
    "nsrd_table1": ("experiment=laptop/nsrd,laptop/nsrr model.previous=2", 14),
    "nsrd_figure6": ("experiment=laptop/nsrd,laptop/nsrr model.previous=2", 2),
    "nsrd_table2": ("experiment=laptop/nsrd", 1),
    "nsrd_table5": ("experiment=laptop/nsrd model/demodulate=log_radiance,log_lighting", 2),
    "nsrd_table5_nsrr": ("experiment=laptop/nsrr model/demodulate=display,log_lighting", 2),
    "nsrd_table6": ("experiment=laptop/nsrd", 4),
    "nsrd_figure8": ("experiment=laptop/nsrd", 2),
    "nsrd_tableS4": ("experiment=laptop/nsrd", 3),
    "dlctus_table2": ("experiment=[laptop/dlctus,dlctus/l1],laptop/nsrr", 6),
}


@pytest.mark.parametrize("name", IN_MINUTES)
def test_a_sweep_takes_the_laptop_s_form_of_its_method(name):
    overrides, count = IN_MINUTES[name]
    jobs = jobs_of(name, *overrides.split())
    assert len(jobs) == count
    for job in jobs:
        cfg = composed(*job)
        assert cfg.data.test.window, "the laptop's clips"
        if cfg.model._target_.endswith("NSRD"):
            assert cfg.model.base._target_.endswith("JitterAlignedBase")
            assert cfg.model.demodulate._target_.endswith(("LoggedLighting", "Radiance"))
            assert cfg.budget.crop == 64
        else:
            assert cfg.budget.crop == 32
            assert "nsrd" in name or cfg.loss._target_.endswith(".L1")


def program(cfg):
    """All of a configuration that an ablation's row can change."""
    return repr([OmegaConf.to_container(cfg[key], resolve=True) for key in ("model", "loss", "task")])


def as_published(word):
    """A word of a job, of DLCTUS with the thesis's recipe in place of the laptop's."""
    word = word.replace("[laptop/dlctus,dlctus/", "[dlctus,dlctus/")
    return word.replace("[laptop/nsrr_published,dlctus/xiao]", "dlctus/xiao_published")


@pytest.mark.parametrize(
    "name", sorted(name for name in set(SWEEPS) & set(TABLES) if name.startswith(("nsrd", "dlctus")))
)
def test_a_sweep_runs_the_table_s_rows(name):
    """By the paper's recipe its jobs are the rows of the table, and no others but those that `EXTRA` names."""
    ran = {program(of_a_row(" ".join(map(as_published, job)))) for job in jobs_of(name)}
    wanted = set()
    for table in (name, *EXTRA.get(name, ())):
        command, rows = TABLES[table]
        wanted |= {program(of_a_row(f"{command} {added}".strip())) for added in rows.values()}
    assert ran == wanted - {
        program(of_a_row(f"{TABLES[t][0]} {TABLES[t][1][row]}".strip())) for t, row in LEFT_OUT if t == name
    }
