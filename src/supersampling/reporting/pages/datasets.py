"""What a report's numbers stand on: the data set, the budget, machines and versions, and the runs that did not enter."""

from collections.abc import Sequence

from supersampling.reporting.pages.material import Material
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.runs.store import Run

# A data preset's parameters in the order of interest, as runs log them.
ENTRIES = {
    "clips": "clips of each scene", "frames": "frames of each clip", "targets": "of them with a target",
    "window": "window of the input, pixels", "samples": "samples per pixel", "candidates": "windows to choose from",
}  # fmt: skip
SPLITS = ("train", "val", "test")


def header(material: Material, used: Sequence[Run]) -> list[list[str]]:
    """The report's head: ``[what, its value]``."""
    experiment, setting = material.experiment, material.choice.setting
    count = len({run.id for run in used})

    def joined(name: str) -> str:
        return "; ".join(sorted({str(getattr(run, name)) for run in used}))

    broken = len({run.id for run in used} & material.store.problems.keys())
    budgets = sorted({run.params["budget"] for run in used if "budget" in run.params})
    return [
        ["data set", f"{setting.data}, fingerprint {setting.dataset}"],
        ["scenes", setting.scenes],
        ["task", f"{setting.scale}×{setting.scale} upsampling, mip bias {setting.mip_bias}"],
        [
            "budget",
            setting.budget + (f" ({', '.join(budgets)})" if budgets not in ([], [setting.budget]) else ""),
        ],
        ["machine", joined("machine")],
        ["version", joined("version")],
        [
            "runs",
            f"{count} in this report; {len(experiment.runs) - count} finished ones of other settings and "
            f"{experiment.unfinished} unfinished or failed ones not in it",
        ],
        *([["incomplete", f"{broken} of the runs lack values; the appendix says which and why"]] if broken else []),
    ]


def sheet(material: Material) -> Sheet:
    """The data set's facts as its runs logged them, a column a split, and how many clips were scored."""
    runs = material.choice.pools[material.choice.setting]
    params = max(runs, key=lambda run: (run.ended, run.id)).params
    rows = []
    for entry, label in ENTRIES.items():
        values = [params.get(f"data.{split}.{entry}", "") for split in SPLITS]
        if any(values):
            rows.append([Text(label), *(Text(value.replace(",", " × ")) for value in values)])
    general = ", ".join(
        f"{label} {params[name].replace(',', ' × ')}"
        for name, label in (
            ("data.frame", "frame"), ("data.camera", "camera"), ("task.jitter", "jitter"), ("data.seed", "seed"),
        )
        if name in params
    )  # fmt: skip
    clips = max((len(table) for table in material.clips.values()), default=0)
    notes = [
        f"Preset {material.choice.setting.data}: {general}." if general else "",
        f"Scored: {clips} clips.",
    ]
    title = f"Data set {material.choice.setting.dataset}."
    return Sheet("dataset", title, [], ["", *SPLITS], rows, 1, [note for note in notes if note])
