"""The appendix: which runs are behind each cell, and what could not be read of them."""

from collections.abc import Sequence
from typing import Any

from supersampling.reporting.pages.material import Material, PaperRuns, figure_runs
from supersampling.reporting.pages.overview import Method
from supersampling.reporting.papers.claims import Judged
from supersampling.reporting.papers.published import name_of
from supersampling.reporting.papers.tables import Filled
from supersampling.runs.store import Run

Cell = tuple[str, list[Run]]
"""What is filled, and with which runs."""


def paper_cells(
    found: Sequence[Method], filled: Sequence[Filled], judged: Sequence[Judged], one: PaperRuns
) -> list[Cell]:
    """Everything that our runs fill, named, with its runs."""
    cells = [(f"Methods · {method.label}", method.runs) for method in found]
    for item in filled:
        name = name_of(item.table.number)
        by_row = item.table.compare == "column" and len(
            {tuple(r.id for r in runs) for runs in item.runs.values()}
        ) < len(item.runs)
        for (row, column), runs in sorted(item.runs.items()):
            labels = "/".join(item.table.rows[row].labels)
            if not by_row:
                cells.append((f"{name} · {labels} · {item.table.columns[column].label}", runs))
            elif column == min(c for r, c in item.runs if r == row):
                cells.append((f"{name} · {labels}", runs))
    figure_cells = [(f"Figure {figure.figure.number}", figure_runs(figure)) for figure in one.figures]
    return cells + claim_cells(judged) + [cell for cell in figure_cells if cell[1]]


def claim_cells(judged: Sequence[Judged]) -> list[Cell]:
    return [
        (f"Claim {item.claim.id} · {label}", runs)
        for item in judged
        for label, runs in item.chosen.runs.items()
        if runs
    ]


def keys_of(cells: Sequence[Cell]) -> dict[str, str]:
    """``R1``, ``R2`` ... by run id."""
    runs = {run.id: run for _, chosen in cells for run in chosen}
    order = sorted(runs.values(), key=lambda run: (run.model, run.name, run.seed, run.id))
    return {run.id: f"R{index + 1}" for index, run in enumerate(order)}


def appendix(cells: Sequence[Cell], material: Material) -> dict[str, Any]:
    """The runs in use, numbered, each with a link to the MLflow UI if there is one, and the numbers behind each cell."""
    keys, runs = keys_of(cells), {run.id: run for _, chosen in cells for run in chosen}
    return {
        "runs": [
            [
                key,
                runs[id].name,
                id[:12],
                runs[id].identity[:12],
                runs[id].dataset[:8],
                runs[id].seed,
                link(id, material),
            ]
            for id, key in keys.items()
        ],
        "cells": [[name, " ".join(keys[run.id] for run in chosen)] for name, chosen in cells],
        "problems": [[keys.get(id, id[:12]), why] for id, why in sorted(material.store.problems.items()) if id in keys],
    }


def link(run_id: str, material: Material) -> str:
    """The run's page in the MLflow UI; empty where the store is no server."""
    uri = material.store.uri.rstrip("/")
    return (
        f"{uri}/#/experiments/{material.experiment.id}/runs/{run_id}" if uri.startswith(("http://", "https://")) else ""
    )
