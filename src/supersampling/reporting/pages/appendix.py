"""The appendix: the runs behind each cell, and what could not be read of them."""

from collections.abc import Mapping, Sequence
from typing import Any

from supersampling.reporting.methods import Method
from supersampling.reporting.pages.material import Material, PaperRuns
from supersampling.reporting.papers.claims import Judged
from supersampling.reporting.papers.published import name_of
from supersampling.reporting.papers.tables import Filled
from supersampling.runs.store import Run

Cell = tuple[str, list[Run]]
"""The name of what is filled, and the runs that fill it."""


def paper_cells(
    methods: Sequence[Method], filled: Sequence[Filled], judged: Sequence[Judged], paper: PaperRuns
) -> list[Cell]:
    """Return the name of everything that our runs fill in a paper's report, with these runs."""
    cells = [(f"Methods · {method.label}", method.runs) for method in methods]
    for table in filled:
        cells += _table_cells(table)
    figure_cells = [(f"Figure {figure.figure.number}", figure.runs) for figure in paper.figures]
    picture_cells = [
        (f"{name_of(item.picture.number)} · {label}", runs)
        for item in paper.pictures
        for label, runs in item.present.items()
    ]
    return cells + claim_cells(judged) + [cell for cell in figure_cells if cell[1]] + picture_cells


def _table_cells(filled: Filled) -> list[Cell]:
    """Return a table's cells; one for each row where all of a row's columns have the same runs."""
    table, name = filled.table, name_of(filled.table.number)
    distinct = {tuple(run.id for run in runs) for runs in filled.runs.values()}
    by_row = table.compare == "column" and len(distinct) < len(filled.runs)
    cells: list[Cell] = []
    for (row, column), runs in sorted(filled.runs.items()):
        labels = "/".join(table.rows[row].labels)
        if not by_row:
            cells.append((f"{name} · {labels} · {table.columns[column].label}", runs))
        elif column == min(c for r, c in filled.runs if r == row):
            cells.append((f"{name} · {labels}", runs))
    return cells


def claim_cells(judged: Sequence[Judged]) -> list[Cell]:
    """Return each side or step of each claim that has runs."""
    return [
        (f"Claim {item.claim.id} · {label}", runs)
        for item in judged
        for label, runs in item.selected.runs.items()
        if runs
    ]


def number_runs(cells: Sequence[Cell]) -> dict[str, str]:
    """Return ``R1``, ``R2`` ... by run id."""
    runs = {run.id: run for _, members in cells for run in members}
    order = sorted(runs.values(), key=lambda run: (run.model, run.name, run.seed, run.id))
    return {run.id: f"R{index + 1}" for index, run in enumerate(order)}


def appendix(cells: Sequence[Cell], keys: Mapping[str, str], material: Material) -> dict[str, Any]:
    """Return the numbered runs, each with a link to the MLflow UI if there is one, and the numbers behind each cell."""
    runs = {run.id: run for _, members in cells for run in members}
    problems = sorted((id, reason) for id, reason in material.store.problems.items() if id in keys)
    return {
        "runs": [[key, *_columns(runs[id]), link(id, material)] for id, key in keys.items()],
        "cells": [[name, " ".join(keys[run.id] for run in members)] for name, members in cells],
        "problems": [[keys[id], reason] for id, reason in problems],
    }


def _columns(run: Run) -> list[str]:
    return [run.name, run.id[:12], run.identity[:12], run.dataset[:8], run.seed]


def link(run_id: str, material: Material) -> str:
    """Return the address of the run's page in the MLflow UI; empty if the store is no server."""
    location = material.store.location
    if not location.is_server:
        return ""
    return f"{location.address}/#/experiments/{material.experiment.id}/runs/{run_id}"
