"""What one report holds, as the template prints it; its tables and figures are also written as files of their own."""

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from supersampling.reporting.figures import crops, epipolar, figures, plots, states
from supersampling.reporting.pages import advice_sheet, claim_sheets, datasets, overview, stress_sheet, table_sheets
from supersampling.reporting.pages.appendix import Cell, appendix, claim_cells, keys_of, paper_cells
from supersampling.reporting.pages.exports import export, rows, words
from supersampling.reporting.pages.material import Material, PaperRuns
from supersampling.reporting.pages.overview import Method
from supersampling.reporting.papers.claims import Judged
from supersampling.reporting.papers.published import name_of, stem_of
from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.papers.tables import fill
from supersampling.reporting.trade.content import trade_content

Data = dict[str, Any]
CROP_METHODS = 7
OVERVIEW = "overview"


def paper_content(one: PaperRuns, material: Material, made: Path) -> Data:
    """A paper's claims, tables, figures and pictures."""
    paper, stem = one.paper, made / one.paper.paper
    judged = material.judged[paper.paper]
    filled = [fill(table, paper, material.clips) for table in one.tables]
    theirs = [part for item in filled for part in table_sheets.sheets(item, paper)]
    facts, pictures = table_sheets.fact_sheets(paper), table_sheets.picture_sheet(paper)
    summary = material.summary
    export([summary, *facts, *pictures], stem)
    words(theirs, stem)
    words([claim_sheets.sheet(judged, paper)] if judged else [], stem)
    for item in filled:
        rows(table_sheets.long_form(item, paper), f"{stem}_table{stem_of(item.table.number)}.csv")
    if judged:
        rows(claim_sheets.long_form(judged), f"{stem}_claims.csv")
    drawn = [_figure(figure, paper, material, stem) for figure in one.figures]
    cells = paper_cells(material.found, filled, judged, one)
    methods = crop_methods(material, {run.model for run in one.runs})
    return {
        "title": paper.title,
        "subtitle": "Our runs beside the published numbers",
        "byline": f"{paper.authors}, {paper.source}",
        "short": paper.short,
        "facts": datasets.header(material, [run for _, runs in cells for run in runs]),
        "claims": [_claims(judged, paper, cells)] if judged else [],
        "overview": [dataclasses.asdict(summary)],
        "tables": [dataclasses.asdict(item) for item in theirs],
        "words": [dataclasses.asdict(item) for item in (*facts, *pictures)],
        "figures": drawn,
        **_pictures(methods, material, made),
        **appendix(cells, material),
    }


def overview_content(material: Material, made: Path) -> Data:
    """All methods, all claims, and what the data set holds."""
    stem = made / OVERVIEW
    found, clips = material.found, material.clips
    judged = [(one.paper, material.judged[one.paper.paper]) for one in material.papers]
    ours = [material.summary, *overview.by_scene(found, clips)]
    data = datasets.sheet(material)
    advice = advice_sheet.sheets(material.store, material.experiment.id)
    extremes = stress_sheet.sheets(material.store, material.experiment.id)
    export([*ours, data, *extremes, *advice], stem)
    every = [claim for _, claims in judged for claim in claims]
    if every:
        rows(claim_sheets.long_form(every), f"{stem}_claims.csv")
    cells: list[Cell] = [(f"All methods · {method.label}", method.runs) for method in found]
    cells += [cell for _, claims in judged for cell in claim_cells(claims)]
    left = material.configurations - len(found)
    note = f"{left} configurations that do not lead their model are left out." if left else ""
    return {
        "title": "All methods and all claims",
        "subtitle": "What our runs say of the papers",
        "byline": "; ".join(one.paper.title for one in material.papers),
        "short": "paper",
        "facts": datasets.header(material, [run for _, runs in cells for run in runs]),
        "claims": [_claims(claims, paper, cells) for paper, claims in judged if claims],
        "overview": [dataclasses.asdict(item) for item in ours],
        "overview_note": note,
        "trade": trade_content(material, stem),
        "tables": [],
        "words": [dataclasses.asdict(data)],
        "advice": [dataclasses.asdict(item) for item in advice],
        "stress": [dataclasses.asdict(item) for item in extremes],
        "figures": _own_figures(material, stem),
        **_pictures(crop_methods(material, set()), material, made),
        **appendix(cells, material),
    }


def crop_methods(material: Material, models: set[str]) -> list[Method]:
    """As many leading methods as fit a page's width: those of ``models`` first, then the better ones."""

    def rank(method: Method) -> tuple[bool, float]:
        psnr = method.average("test/psnr")
        return method.runs[0].model not in models, -math.inf if math.isnan(psnr) else -psnr

    kept = {method.label for method in sorted(material.leading, key=rank)[:CROP_METHODS]}
    return [method for method in material.leading if method.label in kept]


def _pictures(methods: Sequence[Method], material: Material, made: Path) -> Data:
    return {
        "crops": dataclasses.asdict(crops.crop_table(methods, material.crops, made)),
        "epipolar": dataclasses.asdict(epipolar.epipolar_table(methods, material.epipolar, made)),
        "states": [
            dataclasses.asdict(table) for table in states.state_tables(methods, material.states, material.crops, made)
        ],
    }


def _figure(chosen: plots.FigureRuns, paper: Paper, material: Material, stem: Path) -> Data:
    figure = chosen.figure
    metric = next((m for m in paper.metrics.values() if m.ours == figure.metric), None)
    label = table_sheets.metric_label(metric) if metric else figure.metric
    path = Path(f"{stem}_figure{stem_of(figure.number)}.pdf")
    drawn = plots.draw(chosen, material.clips, material.frames, label, path)
    notes = [f"After {name_of(figure.number, 'Figure')} {paper.of}: {figure.caption}.", figure.note]
    if chosen.setting is not None:
        notes.append(f"Ours: {chosen.setting}.")
    if chosen.missing:
        notes.append(f"Not run: {', '.join(chosen.missing)}" + (f" (sweeps={figure.sweep})." if figure.sweep else "."))
    return {"file": path.name if drawn else "", "caption": " ".join(note for note in notes if note)}


def _own_figures(material: Material, stem: Path) -> list[Data]:
    """Frames, training, and quality against cost, of the methods themselves."""
    learned = [method for method in material.leading if not method.classical]
    front = figures.front_figure(material.found, material.clips, Path(f"{stem}_front.pdf"))
    frames = figures.frames_figure(material.leading, material.frames, Path(f"{stem}_frames.pdf"))
    trained = figures.training_figure(learned, material.store, Path(f"{stem}_training.pdf"))
    captions = [
        ("front", front, "PSNR over the test set against parameters and minutes of training, for the leading configuration "
            "of each learned method. The dashed line is the best method without parameters."),
        ("training", trained, f"Training loss and validation PSNR by step, a line a seed, of {trained} of {len(learned)} learned "
            "methods, each in its leading configuration. Losses of different kinds do not compare."),
        ("frames", frames, "PSNR of every test frame, clip after clip, for the leading configuration of each method, mean over "
            "its seeds."),
    ]  # fmt: skip
    return [{"file": f"{stem.name}_{name}.pdf", "caption": caption} for name, count, caption in captions if count]


def _claims(judged: Sequence[Judged], paper: Paper, cells: Sequence[Cell]) -> Data:
    return {
        "paper": f"{paper.authors.split(',')[0]}: {paper.title}",
        "short": paper.short,
        "counts": [list(item) for item in claim_sheets.counts(judged)],
        "rows": claim_sheets.rows(judged, keys_of(cells)),
    }
