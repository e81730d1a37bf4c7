"""The direction of every metric: whether higher or lower values are better, collected from the metric classes."""

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from fnmatch import fnmatchcase
from functools import cache

from supersampling import metrics
from supersampling.metrics.base import Better, Metric


def metric_classes() -> Iterator[type[Metric]]:
    """Yield every class of this package that states `Metric.better`. Imports all its modules."""
    for module in pkgutil.walk_packages(metrics.__path__, f"{metrics.__name__}."):
        for _, member in inspect.getmembers(importlib.import_module(module.name), inspect.isclass):
            if issubclass(member, Metric) and member.__module__ == module.name and "better" in vars(member):
                yield member


@cache
def _directions() -> dict[str, Better]:
    return {pattern: way for metric in metric_classes() for pattern, way in metric.better.items()}


def better(name: str) -> Better | None:
    """Return the direction of the metric that is logged as ``name``; None if no metric has this name.

    With ``neither``, no side of a comparison wins.
    """
    directions = _directions()
    if name in directions:
        return directions[name]
    return next((way for pattern, way in directions.items() if fnmatchcase(name, pattern)), None)
