"""The report: read the runs, fill the tables, draw the figures, typeset, write."""

import dataclasses
import datetime
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import typst
from omegaconf import DictConfig

from supersampling.errors import UserError
from supersampling.reporting import crops, figures, overview, sheet, tables
from supersampling.reporting.overview import Method
from supersampling.reporting.published import Paper, load_paper
from supersampling.reporting.runs import Experiment, Run, Store
from supersampling.reporting.selection import Choice, choose
from supersampling.reporting.typed import as_typed

Data = dict[str, Any]


def write_report(cfg: DictConfig) -> Path:
    """Write ``<paper>.pdf`` and its tables to ``cfg.output``; returns the PDF's path and prints what was written."""
    paper = load_paper(Path(cfg.published) / f"{cfg.paper}.yaml")
    template = Path(cfg.templates) / "report.typ"
    if not template.is_file():
        raise UserError(
            f"there is no template at '{template}': run report.py from the project's root, or set templates"
        )
    with tempfile.TemporaryDirectory(prefix="report-") as folder:
        build = Path(folder)
        store = Store(str(cfg.tracking_uri), build / "artifacts")
        experiment = store.experiment(str(cfg.experiment))
        choice = choose(experiment.runs, as_typed(cfg, "dataset"), _text(cfg.budget))
        made = build / "made"
        made.mkdir()
        data = _content(paper, store, experiment, choice, made)
        shutil.copy(template, build / "report.typ")
        (build / "data.json").write_text(
            json.dumps(data, ensure_ascii=False, sort_keys=True), encoding="utf-8"
        )
        pdf = made / f"{paper.paper}.pdf"
        pdf.write_bytes(_typeset(build))
        written = _publish(made, Path(cfg.output), paper.paper)
    sys.stdout.write(
        f"{choice.setting}: {len(data['runs'])} runs\n" + "".join(f"{path}\n" for path in written)
    )
    return written[0]


def _text(value: object) -> str | None:
    return None if value is None else str(value)


def _content(paper: Paper, store: Store, experiment: Experiment, choice: Choice, made: Path) -> Data:
    """What the template prints; tables and figures are also written to ``made``."""
    pool = choice.pools[choice.setting]
    every = [run for runs in choice.pools.values() for run in runs]
    clips = store.tables(every, "clips")
    found = overview.methods(pool, paper)
    leading = [method for method in found if method.leading]
    leading_runs = [run for method in leading for run in method.runs]
    filled = [tables.fill(table, paper, choice, clips) for table in paper.tables]
    ours = [overview.summary(found, clips), *overview.by_scene(found, clips)]
    theirs = [tables.sheet(item, paper) for item in filled]
    stem = made / paper.paper
    for made_sheet in (*ours, *theirs):
        _export(made_sheet, stem)
    for item in filled:
        rows = pd.DataFrame(tables.long_form(item, paper))
        rows.to_csv(f"{stem}_table{item.table.number}.csv", index=False, lineterminator="\n")
    frames = figures.frames_figure(leading, store.tables(leading_runs, "frames"), Path(f"{stem}_frames.pdf"))
    training = figures.training_figure(found, store, Path(f"{stem}_training.pdf"))
    pictures = crops.crop_table(leading, store.folders(leading_runs, "crops"), made)
    cells = _cells(found, filled)
    return {
        "paper": {key: getattr(paper, key) for key in ("paper", "title", "authors", "source", "short")},
        "facts": _facts(experiment, choice, [run for _, runs in cells for run in runs]),
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "overview": [dataclasses.asdict(item) for item in ours],
        "tables": [dataclasses.asdict(item) for item in theirs],
        "figures": {
            "frames": frames,
            "training": training,
            "trained": sum(not method.classical for method in found),
        },
        "crops": dataclasses.asdict(pictures),
        **_appendix(cells),
    }


def _export(item: sheet.Sheet, stem: Path) -> None:
    """A sheet as CSV (as typeset), Markdown and LaTeX."""
    path = f"{stem}_{item.name}"
    typeset = pd.DataFrame([[cell.text for cell in row] for row in item.rows], columns=item.headers)
    typeset.to_csv(f"{path}.csv", index=False, lineterminator="\n")
    Path(f"{path}.md").write_text(sheet.markdown(item), encoding="utf-8")
    Path(f"{path}.tex").write_text(sheet.latex(item), encoding="utf-8")


def _cells(found: Sequence[Method], filled: Sequence[tables.Filled]) -> list[tuple[str, list[Run]]]:
    """Every cell that our runs fill, named, with its runs."""
    cells = [(f"Overview · {method.label}", method.runs) for method in found]
    for item in filled:
        for (row, column), runs in sorted(item.runs.items()):
            labels = "/".join(item.table.rows[row].labels)
            if item.table.compare == "row":
                cells.append(
                    (f"Table {item.table.number} · {labels} · {item.table.columns[column].label}", runs)
                )
            elif column == 0:
                cells.append((f"Table {item.table.number} · {labels}", runs))
    return cells


def _appendix(cells: Sequence[tuple[str, list[Run]]]) -> Data:
    """The runs in use, numbered, and the numbers behind each cell."""
    runs = {run.id: run for _, chosen in cells for run in chosen}
    order = sorted(runs.values(), key=lambda run: (run.model, run.name, run.seed, run.id))
    keys = {run.id: f"R{index + 1}" for index, run in enumerate(order)}
    rows = [
        [keys[run.id], run.name, run.id[:12], run.identity[:12], run.dataset[:8], run.seed] for run in order
    ]
    return {
        "runs": rows,
        "cells": [[name, " ".join(keys[run.id] for run in chosen)] for name, chosen in cells],
    }


def _facts(experiment: Experiment, choice: Choice, used: Sequence[Run]) -> list[list[str]]:
    setting = choice.setting
    unused = len(experiment.runs) - len({run.id for run in used})

    def joined(name: str) -> str:
        return ", ".join(sorted({str(getattr(run, name)) for run in used}))

    return [
        ["data set", f"{setting.data}, fingerprint {setting.dataset}"],
        ["scenes", setting.scenes],
        ["task", f"{setting.scale}×{setting.scale} upsampling, mip bias {setting.mip_bias}"],
        ["budget", setting.budget],
        ["machine", joined("machine")],
        ["version", joined("version")],
        [
            "runs",
            f"{len({run.id for run in used})} in this report; {unused} finished ones of other settings and "
            f"{experiment.unfinished} unfinished or failed ones not in it",
        ],
    ]


def _typeset(build: Path) -> bytes:
    """The PDF of ``build/report.typ``; only the fonts inside typst, so that the bytes do not depend on the machine."""
    return typst.compile(
        str(build / "report.typ"), root=str(build), ignore_system_fonts=True, timestamp=0, format="pdf"
    )


def _publish(made: Path, output: Path, paper: str) -> list[Path]:
    """Move the report's files to ``output``, each whole or not at all; the PDF comes first in the list."""
    output.mkdir(parents=True, exist_ok=True)
    names = sorted(
        (path for path in made.iterdir() if path.name.startswith(paper)),
        key=lambda p: (p.name != f"{paper}.pdf", p.name),
    )
    written: list[Path] = []
    for source in names:
        beside = output / f".{source.name}.{os.getpid()}"
        shutil.copyfile(source, beside)
        os.replace(beside, output / source.name)
        written.append(output / source.name)
    return written
