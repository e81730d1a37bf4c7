"""Gates forced open and shut: the extremes that models and stages declare in their class attribute ``extremes``."""

import importlib
import pkgutil
from collections.abc import Iterator
from functools import partial

from supersampling import models, stages
from supersampling.models.base import Upsampler
from supersampling.stages.gate import Gate
from supersampling.stress.extreme import Extreme


def declared_gates() -> Iterator[Gate]:
    """Yield the gates that the classes of stages and then of models declare, in order of their modules' names."""
    for package in (stages, models):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            for value in vars(importlib.import_module(module.name)).values():
                if isinstance(value, type) and value.__module__ == module.name:
                    yield from vars(value).get("extremes", ())


def hold(model: Upsampler, name: str) -> bool:
    """Bring a model to the extreme called ``name``, in place; return whether the model or one of its stages has it."""
    matches = [
        (gate, part)
        for part in model.modules()
        for base in type(part).__mro__  # a class declares its own gates only
        for gate in vars(base).get("extremes", ())
        if gate.name == name
    ]
    holds = [gate.hold(part) for gate, part in matches]
    return any(holds)


GATES = tuple(Extreme(g.name, g.meaning, adjust=partial(hold, name=g.name), frames=12) for g in declared_gates())
