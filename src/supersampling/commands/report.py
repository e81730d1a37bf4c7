"""The reports: read the runs, choose, judge, draw, typeset, write."""

import datetime
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import typst
from omegaconf import DictConfig

from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.reporting.pages.content import OVERVIEW, Data, overview_content, paper_content
from supersampling.reporting.pages.material import Material, gather
from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.settings import choose
from supersampling.runs.store import Store

TEMPLATE = "report.typ"


def write_report(cfg: DictConfig) -> list[Path]:
    """Write ``<paper>.pdf`` of one paper, or of every paper and ``overview.pdf``, and their tables to ``cfg.output``.

    Returns the PDFs' paths and prints what was written. Nothing is written unless all of it was made.
    """
    known = load_papers(Path(cfg.published), None)
    papers = known if cfg.paper is None else load_papers(Path(cfg.published), str(cfg.paper))
    template = Path(cfg.templates) / TEMPLATE
    if not template.is_file():
        raise UserError(
            f"there is no template at '{template}': run report.py from the project's root, or set templates"
        )
    with tempfile.TemporaryDirectory(prefix="report-") as folder:
        build = Path(folder)
        store = Store(str(cfg.tracking_uri), build / "artifacts")
        experiment = store.experiment(str(cfg.experiment))
        choice = choose(experiment.runs, as_typed(cfg, "dataset"), _text(cfg.budget))
        material = gather(papers, known, store, experiment, choice)
        names = [paper.paper for paper in papers] + ([OVERVIEW] if cfg.paper is None else [])
        for name in names:
            _make(name, material, build / name, template)
        output = Path(cfg.output)
        written = {name: _publish(build / name / "made", output, name) for name in names}
    _tell(material, written)
    return [files[0] for files in written.values()]


def _text(value: object) -> str | None:
    return None if value is None else str(value)


def _make(name: str, material: Material, build: Path, template: Path) -> None:
    """One report's files in ``build/made``."""
    made = build / "made"
    made.mkdir(parents=True)
    one = next((one for one in material.papers if one.paper.paper == name), None)
    data: Data = overview_content(material, made) if one is None else paper_content(one, material, made)
    data["date"] = datetime.datetime.now(datetime.UTC).date().isoformat()
    shutil.copy(template, build / TEMPLATE)
    (build / "data.json").write_text(json.dumps(data, ensure_ascii=False, sort_keys=True), encoding="utf-8")
    (made / f"{name}.pdf").write_bytes(_typeset(build))


def _typeset(build: Path) -> bytes:
    """The PDF of ``build/report.typ``; only the fonts inside typst, so that the bytes do not depend on the machine."""
    return typst.compile(str(build / TEMPLATE), root=str(build), ignore_system_fonts=True, timestamp=0, format="pdf")


def _publish(made: Path, output: Path, name: str) -> list[Path]:
    """Move a report's files to ``output``, each whole or not at all; the PDF comes first in the list."""
    output.mkdir(parents=True, exist_ok=True)
    names = sorted(
        (path for path in made.iterdir() if path.name.startswith(name)),
        key=lambda p: (p.name != f"{name}.pdf", p.name),
    )
    written: list[Path] = []
    for source in names:
        beside = output / f".{source.name}.{os.getpid()}"
        shutil.copyfile(source, beside)
        os.replace(beside, output / source.name)
        written.append(output / source.name)
    return written


def _tell(material: Material, written: dict[str, list[Path]]) -> None:
    lines = [f"{material.choice.setting}: {len(material.clips)} runs"]
    for files in written.values():
        beside = len(files) - 1
        lines.append(f"{files[0]}" + (f" and {beside} tables and figures beside it" if beside else ""))
    lines += [f"run {run[:12]}: {why}" for run, why in sorted(material.store.problems.items())]
    sys.stdout.write("\n".join(lines) + "\n")
