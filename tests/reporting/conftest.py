from collections.abc import Iterator
from pathlib import Path

import pytest
from stored_runs import CLASSICAL, Log, config

from supersampling.commands.report import report


@pytest.fixture(scope="session")
def log(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Log]:
    """A sweep's runs: classical methods, three seeds of DLCTUS, ablations, and runs that must not count."""
    log = Log(tmp_path_factory.mktemp("store"))
    for model, psnr in CLASSICAL.items():
        log.run(model, psnr, f"{model} x4")
    for seed in range(3):
        log.run("dlctus", 34.37, f"dlctus l1 seed={seed} x4", params={"seed": seed})
    log.run("dlctus", 33.00, "dlctus reproject=bilinear l1 seed=0 x4", params={"model.reproject": "bilinear"})
    log.run("dlctus", 34.31, "dlctus accumulate=none l1 seed=0 x4", params={"model.accumulate": "none"})
    for theta in (0.1, 0.5):
        params = {"loss": "spatiotemporal", "loss.theta": theta}
        log.run("dlctus", 34.3 - theta, f"dlctus theta={theta} seed=0 x4", params=params)
    log.run("dlctus", 99.0, "failed", status="FAILED", params={"model.dilate": "closest"})
    log.run("dlctus", 99.0, "sweep", tags={"ss.kind": "sweep"})
    log.run("dlctus", 55.0, "other budget", params={"budget": "smoke"})
    log.run("jau", 44.0, "jau x2", params={"task.scale": 2}, tags={"ss.dataset": "77aa00bb11cc22dd"})
    return log


@pytest.fixture(scope="session")
def reports(log: Log, tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("out")
    report(config(log, output))
    return output
