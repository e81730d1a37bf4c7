"""Every model of conf/model receives a bad frame and a bad state, and is finite again within its window."""

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from supersampling.config import group_options
from supersampling.stress.recovery import faults, measure_recovery

# Previous frames that a state holds; in other models nothing survives.
WINDOW = {"nsrr": 4, "nsrr_fast": 4, "nsrd": 2}
SLOW = {"enss_m", "enss_l", "nsrr"}


@pytest.mark.parametrize("name", [name for name in group_options("model") if name not in SLOW])
def test_faults_do_not_outlast_the_window(name, project):
    with initialize_config_dir(str(project / "conf"), version_base="1.3"):
        cfg = compose("stress", [f"model={name}", "task.scale=2"])
    torch.manual_seed(0)
    model = instantiate(cfg.model).eval()
    for fault in faults(model):
        _, finite = measure_recovery(model, fault, (5, 4), WINDOW.get(name, 0) + 2, "cpu")
        assert all(finite[WINDOW.get(name, 0) :]), fault
        if fault.split()[0] not in ("state", "high_material", "high_emission"):
            assert finite[0], fault


@pytest.fixture
def project(request):
    return request.config.rootpath
