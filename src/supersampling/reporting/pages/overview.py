"""All methods on the report's own data set, against the best classical one."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.papers.tables import NOT_RUN, number
from supersampling.reporting.selection import configurations, matches, one_per_seed, settings
from supersampling.runs.estimates import ClipTables, clip_scores, difference, estimate, scenes_of
from supersampling.runs.statistics import Estimate, bootstrap_mean
from supersampling.runs.store import Run

SCENES_A_SHEET = 4


@dataclass(frozen=True)
class Method:
    """One configuration and its runs, a run a seed. ``leading`` marks the one that stands for its model."""

    label: str
    runs: list[Run]
    leading: bool

    @property
    def classical(self) -> bool:
        """Whether it has nothing to learn."""
        return self.average("model/parameters") == 0

    def average(self, metric: str) -> float:
        """Mean over seeds of a logged metric, NaN where no run logged it."""
        values = [run.metrics[metric] for run in self.runs if metric in run.metrics]
        return float(np.mean(values)) if values else math.nan


def methods(runs: Sequence[Run], papers: Sequence[Paper]) -> list[Method]:
    """The configurations of one setting, classical ones first; a label names what differs from the model's leading one."""
    found: list[Method] = []
    for model in sorted({run.model for run in runs}):
        groups = configurations(run for run in runs if run.model == model)
        leader = _leader(groups, papers)
        thetas = {settings(group[0]).get("loss.theta") for group in groups}
        for group in sorted(groups, key=lambda group: (group is not leader, _label(group[0], leader[0]))):
            label = _label(group[0], leader[0])
            own = settings(group[0]).get("loss.theta")
            if group is leader and own is not None and len(thetas) > 1:
                label += f", loss.theta={own}"  # the leading theta would be left unsaid
            found.append(Method(label, one_per_seed(group), group is leader))
    return sorted(found, key=lambda method: (not method.classical, method.classical and method.average("test/psnr")))


def _leader(groups: Sequence[list[Run]], papers: Sequence[Paper]) -> list[Run]:
    """The configuration that stands in a paper's first table, else the one nearest to the most common settings."""
    tables = [paper.tables[0] for paper in papers]
    first = [{**table.base, **c.select} for table in tables for c in table.columns if c.select]
    common = Counter(item for group in groups for item in settings(group[0]).items())

    def rank(group: list[Run]) -> tuple[bool, int]:
        in_paper = any(matches(group[0], selection) for selection in first)
        return in_paper, sum(common[item] for item in settings(group[0]).items())

    return max(groups, key=rank)


def _label(run: Run, leader: Run) -> str:
    ours, theirs = settings(run), settings(leader)
    differing = [f"{name.removeprefix('model.')}={value}" for name, value in ours.items() if theirs.get(name) != value]
    return ", ".join([leader.method, *differing])


def short_labels(labels: Sequence[str]) -> list[str]:
    """The labels' first words where these tell them apart."""
    words = [label.split(" ")[0].rstrip(",") for label in labels]
    return words if len(set(words)) == len(words) else list(labels)


def best_classical(found: Sequence[Method], tables: ClipTables) -> Method | None:
    """The classical method with the highest mean PSNR over clips."""
    scores = [(estimate(m.runs, "psnr", tables), m) for m in found if m.classical]
    scored = [(value.mean, method) for value, method in scores if value is not None]
    return max(scored, key=lambda pair: pair[0])[1] if scored else None


def summary(found: Sequence[Method], tables: ClipTables) -> Sheet:
    """PSNR, SSIM, the paired difference against the best classical method, cost."""
    base = best_classical(found, tables)
    heads = ["method", "PSNR (dB)", "SSIM", "Δ PSNR (dB)", "95% interval", "minutes", "parameters", "seeds"]
    rows = [_summary_row(method, base, tables) for method in found]
    clips = max((e.clips for m in found if (e := estimate(m.runs, "psnr", tables))), default=0)
    notes = [
        f"Mean over {clips} test clips ± half the 95% bootstrap interval over scenes, with their clips, and seeds; SSIM with "
        "the 11-tap Gaussian window (ssim_gauss11).",
        f"Δ: mean paired difference over clips and seeds against the best classical method ({base.label})." if base else
        "No classical method was run: differences have no base.",
        "“unresolved”: the interval holds 0. A number in brackets is the spread of the mean PSNR over seeds (highest − lowest).",
    ]  # fmt: skip
    return Sheet("overview", "All methods on this data set.", [], heads, rows, 1, notes, _first_learned(found))


def _summary_row(method: Method, base: Method | None, tables: ClipTables) -> list[Text]:
    psnr, ssim = (estimate(method.runs, name, tables) for name in ("psnr", "ssim"))
    delta = difference(method.runs, base.runs, "psnr", tables) if base is not None and method is not base else None
    minutes, parameters = method.average("train/minutes"), method.average("model/parameters")
    return [
        Text(method.label),
        Text(number(psnr, 2)) if psnr else Text(NOT_RUN, "muted"),
        Text(number(ssim, 4)) if ssim else Text(NOT_RUN, "muted"),
        Text(f"{delta.mean:+.2f}".replace("-", "−")) if delta else Text("base" if method is base else "", "muted"),
        _interval(delta),
        Text("" if math.isnan(minutes) else f"{minutes:.1f}"),
        Text("" if math.isnan(parameters) else f"{parameters:,.0f}".replace(",", " ")),
        Text(_seeds(method)),
    ]


def _interval(delta: Estimate | None) -> Text:
    if delta is None or math.isnan(delta.low):
        return Text("")
    text = f"{delta.low:+.2f} to {delta.high:+.2f}".replace("-", "−")
    return Text(text) if delta.resolved else Text(f"{text}, unresolved", "muted")


def _seeds(method: Method) -> str:
    scores = [run.metrics["test/psnr"] for run in method.runs if "test/psnr" in run.metrics]
    spread = f" ({max(scores) - min(scores):.2f})" if len(scores) > 1 else ""
    return f"{len(method.runs)}{spread}"


def by_scene(found: Sequence[Method], tables: ClipTables) -> list[Sheet]:
    """PSNR and SSIM of each method on each scene; many scenes go on over several sheets."""
    logged = [method for method in found if any(run.id in tables for run in method.runs)]
    scenes = sorted({scene for m in logged for run in m.runs if run.id in tables for scene in tables[run.id]["scene"]})
    chunks = [scenes[i : i + SCENES_A_SHEET] for i in range(0, len(scenes), SCENES_A_SHEET)]
    return [_scene_sheet(logged, tables, chunk, index, len(chunks)) for index, chunk in enumerate(chunks)]


def _scene_sheet(found: Sequence[Method], tables: ClipTables, scenes: list[str], index: int, of: int) -> Sheet:
    rows: list[list[Text]] = []
    counts = dict.fromkeys(scenes, 0)
    for method in found:
        for metric, label, decimals in (("psnr", "PSNR (dB)", 2), ("ssim", "SSIM", 4)):
            values = [_of_scene(method, metric, tables, scene) for scene in scenes]
            cells = [Text(number(v, decimals)) if v else Text(NOT_RUN, "muted") for v in values]
            counts = {scene: max(counts[scene], v.clips if v else 0) for scene, v in zip(scenes, values)}
            rows.append([Text(method.label if metric == "psnr" else ""), Text(label), *cells])
    return Sheet(
        name="scenes" if of == 1 else f"scenes_{index + 1}",
        title="All methods by scene" + ("." if of == 1 else f", part {index + 1} of {of}."),
        groups=[],
        headers=[
            "method",
            "metric",
            *(f"{scene} ({counts[scene]} clip{'s' * (counts[scene] > 1)})" for scene in scenes),
        ],
        rows=rows,
        labels=2,
        notes=[
            "Mean ± half the 95% bootstrap interval over the scene's clips and seeds; a scene with one clip has none."
        ],
        rules=list(range(0, len(rows), 2)),
    )


def _of_scene(method: Method, metric: str, tables: ClipTables, scene: str) -> Estimate | None:
    scores = clip_scores(method.runs, metric, tables)
    if scores is None or scene not in (scenes := scenes_of(scores)):
        return None
    return bootstrap_mean(scores.to_numpy()[scenes == scene].T)


def _first_learned(found: Sequence[Method]) -> list[int]:
    return [index for index, method in enumerate(found) if not method.classical][:1]
