"""All methods on the report's own data set, against the best classical one, and by scene."""

import math
from collections.abc import Sequence

from supersampling.reporting.format import fixed, plus_minus, span, thousands, typeset, unless_resolved
from supersampling.reporting.methods import Method, best_classical
from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.reporting.papers.tables import NOT_RUN
from supersampling.runs.estimates import ClipTables, clip_scores, difference, estimate, scenes_of
from supersampling.runs.statistics import Estimate, bootstrap_mean

SCENES_PER_SHEET = 4


def section(report: Report) -> Section:
    """Return the summary of all methods; in the overview also by scene, and how many configurations are left out."""
    material = report.material
    sheets = [summary(material.methods, material.clips)]
    remark = ""
    if report.subject is None:
        sheets += by_scene(material.methods, material.clips)
        left_out = material.configurations - len(material.methods)
        remark = f"{left_out} configurations that do not lead their model are left out." if left_out else ""
    export(sheets, report.stem)
    return Section(title="Methods on this data set", sheets=sheets, remark=remark)


def summary(methods: Sequence[Method], tables: ClipTables) -> Sheet:
    """Return PSNR, SSIM, the paired difference against the best classical method, and the cost of each method."""
    base = best_classical(methods, tables)
    clips = max((e.clips for m in methods if (e := estimate(m.runs, "psnr", tables))), default=0)
    against = (
        f"Δ: mean paired difference over clips and seeds against the best classical method ({base.label})."
        if base
        else ""
    )
    return Sheet(
        name="overview",
        title="All methods on this data set.",
        headers=["method", "PSNR (dB)", "SSIM", "Δ PSNR (dB)", "95% interval", "minutes", "parameters", "seeds"],
        rows=[_summary_row(method, base, tables) for method in methods],
        notes=[
            f"Mean over {clips} test clips ± half the 95% bootstrap interval over scenes, with their clips, and seeds; "
            "SSIM with the 11-tap Gaussian window (ssim_gauss11).",
            against or "No classical method was run: differences have no base.",
            "“unresolved”: the interval holds 0. A number in brackets is the spread of the mean PSNR over seeds "
            "(highest − lowest).",
        ],
        # Above the first learned method.
        rules=[index for index, method in enumerate(methods) if not method.classical][:1],
    )


def _summary_row(method: Method, base: Method | None, tables: ClipTables) -> list[Text]:
    psnr, ssim = (estimate(method.runs, name, tables) for name in ("psnr", "ssim"))
    delta = difference(method.runs, base.runs, "psnr", tables) if base is not None and method is not base else None
    return [
        Text(method.label),
        _score(psnr, 2),
        _score(ssim, 4),
        Text(typeset(f"{delta.mean:+.2f}")) if delta else Text("base" if method is base else "", "muted"),
        _interval(delta),
        Text(fixed(method.average("train/minutes"), 1)),
        Text(thousands(method.average("model/parameters"))),
        Text(_seeds(method)),
    ]


def _score(value: Estimate | None, places: int) -> Text:
    return Text(typeset(plus_minus(value, places))) if value else Text(NOT_RUN, "muted")


def _interval(delta: Estimate | None) -> Text:
    if delta is None or math.isnan(delta.low):
        return Text("")
    text = typeset(span(delta, 2))
    return Text(text + unless_resolved(delta), "plain" if delta.resolved else "muted")


def _seeds(method: Method) -> str:
    scores = [run.metrics["test/psnr"] for run in method.runs if "test/psnr" in run.metrics]
    spread = f" ({max(scores) - min(scores):.2f})" if len(scores) > 1 else ""
    return f"{len(method.runs)}{spread}"


def by_scene(methods: Sequence[Method], tables: ClipTables) -> list[Sheet]:
    """Return PSNR and SSIM of each method on each scene; many scenes are distributed over several sheets."""
    scored = [method for method in methods if any(run.id in tables for run in method.runs)]
    scenes = sorted({scene for m in scored for run in m.runs if run.id in tables for scene in tables[run.id]["scene"]})
    chunks = [scenes[i : i + SCENES_PER_SHEET] for i in range(0, len(scenes), SCENES_PER_SHEET)]
    return [_scene_sheet(scored, tables, chunk, index, len(chunks)) for index, chunk in enumerate(chunks)]


def _scene_sheet(methods: Sequence[Method], tables: ClipTables, scenes: list[str], index: int, count: int) -> Sheet:
    rows: list[list[Text]] = []
    clips = dict.fromkeys(scenes, 0)
    for method in methods:
        for metric, label, places in (("psnr", "PSNR (dB)", 2), ("ssim", "SSIM", 4)):
            values = [_on_scene(method, metric, tables, scene) for scene in scenes]
            clips = {scene: max(clips[scene], v.clips if v else 0) for scene, v in zip(scenes, values)}
            rows.append(
                [Text(method.label if metric == "psnr" else ""), Text(label), *(_score(v, places) for v in values)]
            )
    heads = [f"{scene} ({clips[scene]} clip{'s' * (clips[scene] > 1)})" for scene in scenes]
    return Sheet(
        name="scenes" if count == 1 else f"scenes_{index + 1}",
        title="All methods by scene" + ("." if count == 1 else f", part {index + 1} of {count}."),
        headers=["method", "metric", *heads],
        rows=rows,
        labels=2,
        notes=[
            "Mean ± half the 95% bootstrap interval over the scene's clips and seeds; a scene with one clip has none."
        ],
        rules=list(range(0, len(rows), 2)),
    )


def _on_scene(method: Method, metric: str, tables: ClipTables, scene: str) -> Estimate | None:
    scores = clip_scores(method.runs, metric, tables)
    if scores is None or scene not in (scenes := scenes_of(scores)):
        return None
    return bootstrap_mean(scores.to_numpy()[scenes == scene].T)
