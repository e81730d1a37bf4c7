"""The configuration of the benchmark."""

from collections.abc import Callable
from functools import partial

import pytest
from omegaconf import DictConfig


@pytest.fixture
def composed(entry: Callable[..., DictConfig]) -> Callable[..., DictConfig]:
    """``composed("model=dlctus", ...)``: what the benchmark would get."""
    return partial(entry, "benchmark")
