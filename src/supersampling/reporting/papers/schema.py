"""The contents of ``reports/published/<paper>.yaml``: a paper's numbers, words, pictures, figures and claims.

A *selection* is a mapping of run parameters to the values that they must have. Field names are the file's keys.
``page`` is 0 if the paper's text has no page marks.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Selection = Mapping[str, str]
Counterpart = Literal[
    "crops", "error_maps", "epipolar", "accumulation", "reweighting", "blending", "mask_over_time", "none"
]
RUN_METRIC = "run:"
BENCHMARK = "benchmark:"
BY_NUMBER = ""


@dataclass(frozen=True, kw_only=True)
class Metric:
    """A printed quantity; ``logged`` names the column of our clip tables (or the run's metric) that holds it, times
    ``factor``.

    ``benchmark:ms``, ``benchmark:parameters`` and ``benchmark:gmac`` (10^9 multiply-accumulates) are what runs of
    ``benchmark.py`` measured. A cell's selection then names the target's ``size``, and possibly the ``part`` of the
    method (``a + b - c`` adds parts, ``a|b`` takes the first that the method has), the ``backend`` and the
    ``precision``. ``logged`` is ``None`` for a quantity that is never measured here.
    """

    label: str
    unit: str
    better: Literal["higher", "lower"]
    decimals: int
    logged: str | None
    factor: float = 1.0


@dataclass(frozen=True)
class Column:
    """A column; ``select`` is ``None`` for a method that this project lacks."""

    label: str
    select: Selection | None
    metrics: list[str]


@dataclass(frozen=True)
class Row:
    """A row; ``values[c][m]`` is the published number of column ``c``'s ``m``-th metric, ``None`` if it is lost or
    empty.

    ``select`` is ``None`` for a method that this project lacks.
    """

    labels: list[str]
    select: Selection | None
    values: list[list[float | None]]


@dataclass(frozen=True, kw_only=True)
class Placed:
    """An item of a paper with a number and a title."""

    number: str
    section: str
    page: int = 0
    title: str
    note: str = ""

    @property
    def caption(self) -> str:
        """``Title (Section 3.2, p. 5 ff.)``, without the page if it is not known."""
        page = f", p. {self.page} ff." if self.page else ""
        return f"{self.title.rstrip('.')} (Section {self.section}{page})"


@dataclass(frozen=True, kw_only=True)
class PublishedTable(Placed):
    """One table of a paper, and the selections of our runs for its cells.

    Attributes:
        source: whether our numbers are means of clip scores or metrics that the runs logged themselves.
        file: the sweep that runs the rows (`BY_NUMBER`: ``<paper>_table<number>``).
        lost: which numbers the text lacks.
        command: the command that measures the ``benchmark:`` metrics.
    """

    compare: Literal["row", "column"]
    headers: list[str]
    base: Selection
    columns: list[Column]
    rows: list[Row]
    lost: str = ""
    source: Literal["clips", "run"] = "clips"
    file: str | None = BY_NUMBER
    prefer: Selection | None = None
    command: str = ""

    @property
    def selections(self) -> dict[tuple[int, int], Selection]:
        """The selection of each cell ``(row, column)`` that this project can fill."""
        return {
            (r, c): {**self.base, **row.select, **column.select}
            for r, row in enumerate(self.rows)
            for c, column in enumerate(self.columns)
            if row.select is not None and column.select is not None
        }


@dataclass(frozen=True, kw_only=True)
class FactTable(Placed):
    """A table of words or of facts about data, without numbers to compare with ours."""

    headers: list[str]
    rows: list[list[str]]
    lost: str = ""


@dataclass(frozen=True)
class Series:
    """One line, box or bar of a figure, one of several pictures side by side, or one step of a claim."""

    label: str
    select: Selection


@dataclass(frozen=True, kw_only=True)
class Picture(Placed):
    """A table or figure made of pictures, and our runs whose pictures show the same.

    Attributes:
        counterpart: the kind of our pictures; for ``none``, ``note`` says why there are none.
        series: the runs whose pictures stand side by side.
        scenes: only these are drawn, such as those with text; all if empty.
    """

    counterpart: Counterpart
    series: list[Series] = field(default_factory=list)
    base: Selection = field(default_factory=dict)
    sweep: str | None = None
    scenes: list[str] = field(default_factory=list)

    @property
    def selections(self) -> dict[str, Selection]:
        return {series.label: {**self.base, **series.select} for series in self.series}


@dataclass(frozen=True, kw_only=True)
class PublishedFigure(Placed):
    """A figure drawn from numbers.

    Attributes:
        kind: ``training`` draws what runs logged after every epoch.
        metric: a column of the clip or frame tables; for ``training`` a metric that runs logged, such as ``val/psnr``.
        more: further metrics, each with a panel of its own.
        x: a run parameter, a run metric, or ``frame``; of boxes ``frame`` makes every frame a value. Boxes and bars
            need none, and training has none.
    """

    kind: Literal["box", "curve", "bars", "front", "training"]
    metric: str
    series: list[Series]
    more: list[str] = field(default_factory=list)
    base: Selection = field(default_factory=dict)
    sweep: str | None = None
    x: str | None = None

    @property
    def metrics(self) -> list[str]:
        return [self.metric, *self.more]


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A conclusion of a paper, as a statement about the paired difference ``a - b``, or about every step of a series.

    Attributes:
        metric: a column of the clip tables, or, with ``run:`` before it, a metric that runs logged, or one of
            benchmarks (see `Metric`).
        frames: the first and the last frame of each clip, from 0, that the claim is about; the mean over them counts.
        settles: the quantity is how many frames pass until the metric is this close to its median over the second
            half of the clip.
        at_least: the smallest difference in the claimed direction; if negative, the largest one against it.
        times: ``a`` is claimed to be less by this factor.
        relative: differences of logged metrics are in percent of ``b``.
        published: the paper's own difference (for steps: last minus first).
    """

    id: str
    text: str
    source: str
    page: int = 0
    kind: Literal["more", "less", "same", "falls", "rises"]
    metric: str
    unit: str
    base: Selection = field(default_factory=dict)
    a: Selection | None = None
    b: Selection | None = None
    margin: float | None = None
    frames: list[int] | None = None
    settles: float | None = None
    at_least: float = 0.0
    times: float = 1.0
    relative: bool = False
    steps: list[Series] = field(default_factory=list)
    published: float | None = None
    where: str = ""
    needs: str = ""

    @property
    def exact(self) -> bool:
        """Whether it is about a number that runs log themselves, which has no interval."""
        return self.metric.startswith((RUN_METRIC, BENCHMARK))

    @property
    def stepwise(self) -> bool:
        return self.kind in ("falls", "rises")

    @property
    def over_frames(self) -> bool:
        """Whether the claim needs the scores of single frames."""
        return self.frames is not None or self.settles is not None

    @property
    def selections(self) -> dict[str, Selection]:
        """The compared selections by label, in order: the steps, or ``b`` before ``a``."""
        if self.stepwise:
            return {step.label: {**self.base, **step.select} for step in self.steps}
        return {"b": {**self.base, **(self.b or {})}, "a": {**self.base, **(self.a or {})}}


@dataclass(frozen=True, kw_only=True)
class Paper:
    """A paper's contents, each list in its own order."""

    paper: str
    title: str
    authors: str
    source: str
    short: str
    metrics: dict[str, Metric]
    tables: list[PublishedTable]
    facts: list[FactTable] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    figures: list[PublishedFigure] = field(default_factory=list)
    claims: list[Claim] = field(default_factory=list)

    @property
    def of(self) -> str:
        """``of Xiao et al.``, or ``of the thesis`` if `short` is no name."""
        return f"of the {self.short}" if self.short[:1].islower() else f"of {self.short}"


def full_stop(sentence: str) -> str:
    """Return the sentence with a full stop unless it already ends in one, or in an exclamation or question mark."""
    return sentence if sentence.endswith((".", "!", "?")) else f"{sentence}."
