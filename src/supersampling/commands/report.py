"""The command ``report``: read the runs, choose, judge, draw, typeset, write."""

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
from supersampling.reporting.pages.material import Material, PaperRuns, gather
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.sections import content
from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.settings import choose
from supersampling.runs.store import Store

TEMPLATE = "report.typ"


def report(cfg: DictConfig) -> list[Path]:
    """Write ``<paper>.pdf`` of one paper, or of every paper and ``overview.pdf``, and their tables to ``cfg.output``.

    Return the PDFs' paths, and print what was written. Nothing is written if any of it cannot be made.
    """
    known = load_papers(Path(cfg.published), None)
    papers = known if cfg.paper is None else load_papers(Path(cfg.published), str(cfg.paper))
    template = Path(cfg.templates) / TEMPLATE
    if not template.is_file():
        raise UserError(f"There is no template at {template}: run report.py from the project's root, or set templates.")
    with tempfile.TemporaryDirectory(prefix="report-") as folder:
        build = Path(folder)
        store = Store(cfg.tracking_uri, build / "artifacts")
        experiment = store.experiment(str(cfg.experiment_name), ("job", "evaluation"))
        choice = choose(experiment.runs, as_typed(cfg, "dataset"), None if cfg.budget is None else str(cfg.budget))
        material = gather(papers, known, store, experiment, choice)
        subjects: list[PaperRuns | None] = [*material.papers, *([None] if cfg.paper is None else [])]
        reports = [_build(material, subject, build, template) for subject in subjects]
        written = {item.name: _publish(item, Path(cfg.output)) for item in reports}
    _print_summary(material, written)
    return [files[0] for files in written.values()]


def _build(material: Material, subject: PaperRuns | None, build: Path, template: Path) -> Report:
    """Write one report's files to ``build/<name>/made``."""
    item = Report(material, subject, build)
    folder = item.folder.parent
    item.folder.mkdir(parents=True)
    data = content(item)
    data["date"] = datetime.datetime.now(datetime.UTC).date().isoformat()
    shutil.copy(template, folder / TEMPLATE)
    (folder / "data.json").write_text(json.dumps(data, ensure_ascii=False, sort_keys=True), encoding="utf-8")
    Path(f"{item.stem}.pdf").write_bytes(_typeset(folder))
    return item


def _typeset(build: Path) -> bytes:
    """Return the PDF of ``build/report.typ``, with typst's own fonts only: the bytes do not depend on the machine."""
    return typst.compile(str(build / TEMPLATE), root=str(build), ignore_system_fonts=True, timestamp=0, format="pdf")


def _publish(item: Report, output: Path) -> list[Path]:
    """Move a report's files to ``output``, each whole or not at all; the PDF comes first in the list."""
    output.mkdir(parents=True, exist_ok=True)
    sources = [path for path in item.folder.iterdir() if path.name.startswith(item.name)]
    written: list[Path] = []
    for source in sorted(sources, key=lambda path: (path.name != f"{item.name}.pdf", path.name)):
        partial = output / f".{source.name}.{os.getpid()}"
        shutil.copyfile(source, partial)
        os.replace(partial, output / source.name)
        written.append(output / source.name)
    return written


def _print_summary(material: Material, written: dict[str, list[Path]]) -> None:
    lines = [f"{material.choice.setting}: {len(material.clips)} runs"]
    for files in written.values():
        beside = len(files) - 1
        lines.append(f"{files[0]}" + (f" and {beside} tables and figures beside it" if beside else ""))
    lines += [f"run {run[:12]}: {reason}" for run, reason in sorted(material.store.problems.items())]
    sys.stdout.write("\n".join(lines) + "\n")
