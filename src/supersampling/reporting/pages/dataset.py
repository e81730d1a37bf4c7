"""The basis of a report's numbers: the data set, the budget, machines and versions, and the runs that did not enter."""

from collections.abc import Sequence

from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.material import Material
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.runs.store import Run

# A data preset's parameters in the order of interest, as runs log them.
ENTRIES = {
    "clips": "clips of each scene",
    "frames": "frames of each clip",
    "targets": "of them with a target",
    "window": "window of the input, pixels",
    "samples": "samples per pixel",
    "candidates": "windows to choose from",
}
GENERAL = {"data.frame": "frame", "data.camera": "camera", "task.jitter": "jitter", "data.seed": "seed"}
SPLITS = ("train", "val", "test")


def section(report: Report) -> Section | None:
    """Return the data set's facts; None for a paper's report."""
    if report.subject is not None:
        return None
    facts = sheet(report.material)
    export([facts], report.stem)
    return Section(title="The data set", sheets=[facts])


def header(material: Material, used: Sequence[Run]) -> list[list[str]]:
    """Return the head of a report with these runs as pairs of a name and a value."""
    experiment, setting = material.experiment, material.choice.setting
    count = len({run.id for run in used})
    broken = len({run.id for run in used} & material.store.problems.keys())
    budgets = sorted({run.params["budget"] for run in used if "budget" in run.params})
    exact = f" ({', '.join(budgets)})" if budgets not in ([], [setting.budget]) else ""
    facts = {
        "data set": f"{setting.data}, fingerprint {setting.dataset}",
        "scenes": setting.scenes,
        "task": f"{setting.scale}×{setting.scale} upsampling, mip bias {setting.mip_bias}",
        "budget": setting.budget + exact,
        "machine": "; ".join(sorted({run.machine for run in used})),
        "version": "; ".join(sorted({run.version for run in used})),
        "runs": f"{count} in this report; {len(experiment.runs) - count} finished ones of other settings and "
        f"{experiment.unfinished} unfinished or failed ones not in it",
    }
    if broken:
        facts["incomplete"] = f"{broken} of the runs lack values; the appendix says which and why"
    return [list(item) for item in facts.items()]


def sheet(material: Material) -> Sheet:
    """Return the data set's facts as its runs logged them, one column per split, and how many clips were scored."""
    setting = material.choice.setting
    params = max(material.choice.pools[setting], key=lambda run: (run.ended, run.id)).params
    rows = []
    for entry, label in ENTRIES.items():
        values = [params.get(f"data.{split}.{entry}", "") for split in SPLITS]
        if any(values):
            rows.append([Text(label), *(Text(_times(value)) for value in values)])
    general = ", ".join(f"{label} {_times(params[name])}" for name, label in GENERAL.items() if name in params)
    clips = max((len(table) for table in material.clips.values()), default=0)
    notes = [f"Preset {setting.data}: {general}." if general else "", f"Scored: {clips} clips."]
    return Sheet(
        name="dataset",
        title=f"Data set {setting.dataset}.",
        headers=["", *SPLITS],
        rows=rows,
        notes=[note for note in notes if note],
    )


def _times(value: str) -> str:
    return value.replace(",", " × ")
