"""Configuration of the benchmark."""

from collections.abc import Callable
from functools import partial

import pytest
from omegaconf import DictConfig


@pytest.fixture
def composed(entry: Callable[..., DictConfig]) -> Callable[..., DictConfig]:
    """Return a function: ``composed("model=dlctus", ...)`` is the configuration of the benchmark."""
    return partial(entry, "benchmark")
