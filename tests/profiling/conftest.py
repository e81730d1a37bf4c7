"""The configuration of the benchmark."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from omegaconf import DictConfig


@pytest.fixture
def composed() -> Callable[..., DictConfig]:
    """``composed("model=dlctus", ...)``: what the benchmark would get."""

    def make(*overrides: str) -> DictConfig:
        GlobalHydra.instance().clear()
        conf = Path(__file__).resolve().parents[2] / "conf"
        with initialize_config_dir(str(conf), version_base="1.3"):
            return compose("benchmark", list(overrides))

    return make
