"""Every model of conf/model takes a bad frame and a bad state, and is finite again within its window."""

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from supersampling.stress.plan import FULL_MODELS
from supersampling.stress.recovery import faults, recovery

WINDOW = {
    "nsrr": 4,
    "nsrr_fast": 4,
    "nsrd": 2,
}  # previous frames that a state holds; elsewhere nothing survives


@pytest.mark.parametrize("name", [n for n in FULL_MODELS if n not in ("enss_m", "enss_l", "nsrr")])
def test_no_fault_lasts(name, project):
    with initialize_config_dir(str(project / "conf"), version_base="1.3"):
        cfg = compose("stress", [f"model={name}", "task.scale=2"])
    torch.manual_seed(0)
    model = instantiate(cfg.model).eval()
    for fault in faults(model):
        _, finite = recovery(model, fault, (5, 4), WINDOW.get(name, 0) + 2, "cpu")
        assert all(finite[WINDOW.get(name, 0) :]), fault
        if fault.split()[0] not in ("state", "high_material", "high_emission"):
            assert finite[0], fault


@pytest.fixture
def project(request):
    return request.config.rootpath
