"""Measurements of benchmarks by run parameters: times of parts, sizes of modules, rendering."""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Any

import pandas as pd

from supersampling.runs.store import Run, Store
from supersampling.runs.timing import MODULES, PARAMETERS, RENDERINGS, STAGES, TABLE, Timing, timings_of

MS, PARAMETER_COUNT, GMAC = "ms", "parameters", "gmac"
WHOLE, TOTAL = "whole", "total"
NO_METHOD = "none"
"""``model`` of a frame that is rendered at the target's resolution and needs no upsampling."""
DEFAULT_PART = {MS: WHOLE, PARAMETER_COUNT: TOTAL, GMAC: TOTAL}
_SIGN = re.compile(r" ([+-]) ")
_KEYS = ("architecture", "width", "height")
_WAY = ("backend", "precision", "device", "threads")

Tables = Mapping[str, pd.DataFrame]


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """One method as a benchmark measured it, at one size under one backend and precision.

    Attributes:
        benchmark: the benchmark's run.
        run: the same with the method's parameters, ``size`` (``1920x1080``), ``backend``, ``precision``, ``device`` and
            ``threads`` for its parameters.
        quantities: numbers by part: milliseconds (`MS`), parameters, 10^9 multiply-accumulates. The part `WHOLE` is the
            median frame; ``render`` and ``render.x`` are the renderer's.
        renderer: what rendered, empty if nothing was.
    """

    benchmark: Run
    run: Run
    quantities: Mapping[str, Mapping[str, float]]
    renderer: str = ""

    def value(self, quantity: str, part: str = "") -> float | None:
        """Return a quantity of a part, of a sum ``a + b - c`` of parts, or of the first of ``a|b`` that it has.

        None if a part was not measured. Without a part: of the whole method.
        """
        numbers = self.quantities.get(quantity, {})
        values = (_sum(text, numbers) for text in (part or DEFAULT_PART[quantity]).split("|"))
        return next((value for value in values if value is not None), None)

    @property
    def where(self) -> str:
        """``float32, cpu, 2 threads; Linux x86_64 ...``."""
        names = [self.run.params[name] for name in ("precision", "device")]
        count = self.run.params["threads"]
        threads = [f"{count} thread{'s' * (count != '1')}"] if self.run.params["device"] == "cpu" else []
        return f"{', '.join([*names, *threads])}; {self.benchmark.machine}"


def _sum(text: str, numbers: Mapping[str, float]) -> float | None:
    first, *rest = _SIGN.split(text.strip())
    terms = [("+", first), *zip(rest[::2], rest[1::2])]
    if any(name not in numbers for _, name in terms):
        return None
    return sum(numbers[name] if sign == "+" else -numbers[name] for sign, name in terms)


def read_measurements(store: Store, experiment_id: str) -> list[Measurement]:
    """Return what each finished benchmark measured, oldest first.

    Benchmarks of versions that did not log the parameters of their methods are left out.
    """
    files: dict[str, dict[str, pd.DataFrame]] = defaultdict(dict)
    runs: dict[str, Run] = {}
    for name in (TABLE, STAGES, PARAMETERS, MODULES, RENDERINGS):
        for run, table in store.logged(experiment_id, "benchmark", name):
            files[run.id][name], runs[run.id] = table, run
    ordered = sorted(runs.values(), key=lambda run: (run.ended, run.id))
    return [item for run in ordered if PARAMETERS in files[run.id] for item in _of_run(run, files[run.id])]


def _of_run(run: Run, tables: Tables) -> list[Measurement]:
    parameters: dict[str, dict[str, str]] = defaultdict(dict)
    for row in _rows(tables, PARAMETERS):
        parameters[row["architecture"]][row["name"]] = str(row["value"])
    stages = _parts(tables, STAGES, (*_KEYS, *_WAY), "part", MS)
    modules = {name: _parts(tables, MODULES, _KEYS, "module", name) for name in (PARAMETER_COUNT, GMAC)}
    rendered = _parts(tables, RENDERINGS, _KEYS, "part", MS)
    renderer = next((str(row["renderer"]) for row in _rows(tables, RENDERINGS)), "")
    timings = [timing for timing in timings_of(tables[TABLE]) if timing.runs]
    measurements = []
    for timing in timings:
        key, way = tuple(getattr(timing, k) for k in _KEYS), tuple(getattr(timing, k) for k in _WAY)
        quantities = {
            MS: {WHOLE: timing.ms, **stages.get((*key, *way), {}), **rendered.get(key, {})},
            PARAMETER_COUNT: {TOTAL: float(timing.parameters), **modules[PARAMETER_COUNT].get(key, {})},
            GMAC: {TOTAL: timing.gmac, **modules[GMAC].get(key, {})},
        }
        measurements.append((parameters[timing.architecture], timing, quantities, renderer if key in rendered else ""))
    for (architecture, width, height), parts in rendered.items():
        for timing in _ways(timings) if architecture == "" else ():
            at_target = replace(timing, width=width, height=height)
            # Nothing is upsampled.
            measurements.append(
                ({"model": NO_METHOD, "task.scale": "1"}, at_target, {MS: {WHOLE: 0.0, **parts}}, renderer)
            )
    return [
        Measurement(benchmark=run, run=_described(run, index, *item[:2]), quantities=item[2], renderer=item[3])
        for index, item in enumerate(measurements)
    ]


def _ways(timings: Sequence[Timing]) -> list[Timing]:
    """Return one timing for each way to run a method: backend, precision, device and threads."""
    return list({tuple(getattr(timing, name) for name in _WAY): timing for timing in timings}.values())


def _described(run: Run, index: int, parameters: Mapping[str, str], timing: Timing) -> Run:
    way = {name: str(getattr(timing, name)) for name in _WAY}
    size = f"{timing.width}x{timing.height}"
    return replace(run, id=f"{run.id}:{index}", params={**parameters, **way, "size": size})


def _parts(tables: Tables, name: str, keys: Iterable[str], part: str, value: str) -> dict[Any, dict[str, float]]:
    """Return the values of a table's parts by its keys; the mean of several rows of one part (scenes)."""
    values: dict[Any, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for row in _rows(tables, name):
        values[tuple(row[key] for key in keys)][row[part]].append(float(row[value]))
    return {key: {name: fmean(numbers) for name, numbers in parts.items()} for key, parts in values.items()}


def _rows(tables: Tables, name: str) -> list[dict[str, Any]]:
    return tables[name].to_dict("records") if name in tables else []  # type: ignore[return-value]
