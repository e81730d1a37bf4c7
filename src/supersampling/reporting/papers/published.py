"""Reading and checking ``reports/published/<paper>.yaml``: a paper's own numbers and claims."""

import re
import types
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import yaml

from supersampling.errors import UserError
from supersampling.reporting.papers.quantity_checks import check_quantity
from supersampling.reporting.papers.schema import (
    BY_NUMBER,
    Claim,
    Paper,
    Picture,
    PublishedFigure,
    PublishedTable,
    Selection,
)
from supersampling.reporting.papers.times import quantity_of
from supersampling.runs.measurements import DEFAULT_PART

# 2, or S2 of a supplement.
NUMBER = re.compile(r"[A-Z]?\d+[a-z]?")
# The loader of libyaml is ten times faster.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
KINDS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}
T = TypeVar("T")


def load_papers(folder: Path, name: str | None) -> list[Paper]:
    """Return the paper ``name``, or every paper of the folder, by name."""
    if name is not None:
        return [load_paper(folder / f"{name}.yaml")]
    paths = sorted(folder.glob("*.yaml"))
    if not paths:
        raise UserError(f"There are no published numbers in {folder}: set published to a folder that has them.")
    return [load_paper(path) for path in paths]


def load_paper(path: Path) -> Paper:
    """Read and check a file; raise `UserError` with the place of a missing, unknown or mistyped entry."""
    if not path.is_file():
        raise UserError(f"There are no published numbers at {path}: choose a paper that has a file there.")
    try:
        raw = yaml.load(path.read_text(encoding="utf-8"), LOADER)
    except yaml.YAMLError as error:
        raise UserError(f"Invalid YAML in {path}: correct it ({error}).") from error
    paper = _build(Paper, raw, str(path))
    _check_places(paper, str(path))
    _check_metrics(paper, str(path))
    for table in paper.tables:
        _check_table(table, paper, f"{path}: table {table.number}")
        _check_measured(table, paper, f"{path}: table {table.number}")
    for fact in paper.facts:
        for row in fact.rows:
            if len(row) != len(fact.headers):
                raise UserError(
                    f"{path}: facts {fact.number}: Invalid row {row}: use a cell for each of {fact.headers}."
                )
    for picture in paper.pictures:
        _check_picture(picture, f"{path}: {picture.number}")
    for figure in paper.figures:
        _check_figure(figure, f"{path}: figure {figure.number}")
    for claim in paper.claims:
        _check_claim(claim, paper, f"{path}: claim {claim.id}")
    return paper


def name_of(number: str, kind: str = "Table") -> str:
    """Return ``Table 2``; the own name of a remark of the text, which has no number."""
    return f"{kind} {number}" if NUMBER.fullmatch(number) else number[:1].upper() + number[1:]


def stem_of(number: str) -> str:
    """Return a table's or figure's number as it stands in file names."""
    return re.sub(r"\W+", "_", number)


def sweep_of(table: PublishedTable, paper: Paper) -> str | None:
    """Return the name of the sweep in ``sweeps/`` that runs a table's rows, None if there is none."""
    return f"{paper.paper}_table{table.number}" if table.file == BY_NUMBER else table.file


def _check_places(paper: Paper, path: str) -> None:
    """Raise `UserError` unless numbers and ids are unique and pages are at least 0."""
    numbered: dict[str, Sequence[Any]] = {"table": paper.tables, "facts": paper.facts, "figure": paper.figures}
    for kind, items in numbered.items():
        _check_unique((item.number for item in items), f"{path}: {kind} numbers")
    _check_unique((claim.id for claim in paper.claims), f"{path}: claim ids")
    places = [
        (item.number, item.page)
        for items in (paper.tables, paper.facts, paper.pictures, paper.figures)
        for item in items
    ]
    for name, page in [*places, *((claim.id, claim.page) for claim in paper.claims)]:
        if page < 0:
            raise UserError(f"{path}: {name}: Invalid page={page}: use at least 1, or 0 if it is unknown.")


def _check_metrics(paper: Paper, path: str) -> None:
    """Raise `UserError` for a metric of benchmarks that they do not measure."""
    for name, metric in paper.metrics.items():
        quantity = quantity_of(metric.logged)
        if quantity is not None and quantity not in DEFAULT_PART:
            raise UserError(
                f"{path}: metrics.{name}: Invalid logged={metric.logged}: use benchmark: and one of "
                f"{', '.join(DEFAULT_PART)}."
            )


def _check_unique(values: Iterable[str], place: str) -> None:
    items = list(values)
    repeated = sorted({value for value in items if items.count(value) > 1})
    if repeated:
        raise UserError(f"{place}: {', '.join(repeated)} more than once: use each only once.")


def _check_table(table: PublishedTable, paper: Paper, place: str) -> None:
    for column in table.columns:
        unknown = [name for name in column.metrics if name not in paper.metrics]
        if unknown or not column.metrics:
            raise UserError(
                f"{place}: Invalid metrics={column.metrics} of column {column.label}: choose from "
                f"{list(paper.metrics)}."
            )
    expected = [len(column.metrics) for column in table.columns]
    if table.compare == "row" and len(set(map(tuple, (column.metrics for column in table.columns)))) != 1:
        raise UserError(f"{place}: Columns that are compared along a row differ in their metrics: use the same.")
    for row in table.rows:
        if [len(values) for values in row.values] != expected:
            raise UserError(
                f"{place}: Invalid values={row.values} of row {row.labels}: use {expected} numbers by column."
            )
        if len(row.labels) != len(table.headers):
            raise UserError(f"{place}: Invalid labels={row.labels} of a row: use one for each of {table.headers}.")
        if not table.lost and any(value is None for values in row.values for value in values):
            raise UserError(f"{place}: Row {row.labels} has a null: say in lost what is missing and why.")


def _check_measured(table: PublishedTable, paper: Paper, place: str) -> None:
    """Raise `UserError` for a cell of a ``benchmark:`` metric that no benchmark can fill."""
    for (row, column), selection in table.selections.items():
        for name in table.columns[column].metrics:
            logged = paper.metrics[name].logged
            if quantity_of(logged) is None:
                continue
            if "size" not in selection:
                labels = f"{table.rows[row].labels} and {table.columns[column].label}"
                raise UserError(f"{place}: Missing size of {labels}: add size, such as 1920x1080, to the selection.")
            if not table.command:
                raise UserError(f"{place}: Missing command of a benchmark: metric: add the command that measures it.")


def _check_figure(figure: PublishedFigure, place: str) -> None:
    if figure.kind in ("curve", "front") and figure.x is None:
        raise UserError(f"{place}: Missing x of a {figure.kind}: use a run parameter or metric, or frame for a curve.")
    _check_unique((series.label for series in figure.series), f"{place}: labels of series")


def _check_picture(picture: Picture, place: str) -> None:
    if (picture.counterpart == "none") != (not picture.series):
        raise UserError(
            f"{place}: Invalid series of counterpart={picture.counterpart}: name the runs whose pictures are drawn, or "
            "none of them for none."
        )
    if picture.counterpart == "none" and not picture.note:
        raise UserError(f"{place}: Missing note of counterpart=none: say why nothing is drawn.")
    _check_unique((series.label for series in picture.series), f"{place}: labels of series")


def _check_claim(claim: Claim, paper: Paper, place: str) -> None:
    if not claim.id.startswith(f"{paper.paper}-"):
        raise UserError(f"{place}: Invalid id={claim.id}: begin it with {paper.paper}-.")
    if claim.stepwise:
        if len(claim.steps) < 2:
            raise UserError(f"{place}: Too few steps of kind={claim.kind}: use at least two.")
        if claim.a not in (None, claim.steps[-1].select) or claim.b not in (None, claim.steps[0].select):
            raise UserError(f"{place}: Invalid a or b: use the last step as a and the first as b, or leave both out.")
        _check_unique((step.label for step in claim.steps), f"{place}: labels of steps")
    elif claim.a is None or claim.b is None or claim.steps:
        raise UserError(f"{place}: Invalid sides of kind={claim.kind}: use a and b, and no steps.")
    elif claim.a == claim.b:
        raise UserError(f"{place}: The sides a and b are the same selection: use different ones.")
    if quantity_of(claim.metric) is not None and any("size" not in side for side in claim.selections.values()):
        raise UserError(f"{place}: Missing size of metric={claim.metric}: add size, such as 1920x1080, to base.")
    if (claim.kind == "same") != (claim.margin is not None) or (claim.margin is not None and claim.margin <= 0):
        raise UserError(
            f"{place}: Invalid margin={claim.margin} of kind={claim.kind}: use a positive one for same, none for "
            "others."
        )
    check_quantity(claim, place)


def _build(cls: type[T], raw: Any, place: str) -> T:
    """Return a dataclass of a mapping, recursively."""
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    if not isinstance(raw, dict):
        raise UserError(f"{place}: Invalid value {raw!r}: use a mapping with {list(known)}.")
    unknown = sorted(set(map(str, raw)) - set(known))
    if unknown:
        raise UserError(f"{place}: Unknown keys {unknown}: choose from {sorted(known)}.")
    optional = {name for name, f in known.items() if f.default is not MISSING or f.default_factory is not MISSING}
    missing = sorted(set(known) - optional - set(raw))
    if missing:
        raise UserError(f"{place}: Missing keys {missing}: add them.")
    values = {}
    for name, value in raw.items():
        if value == [] and name in optional:
            values[name] = value
        else:
            values[name] = _convert(known[name].type, value, f"{place}: {name}")
    return cls(**values)


def _convert(kind: Any, value: Any, place: str) -> Any:
    """Return a value, checked against an annotation of the schema's dataclasses."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind == Selection:
        return _selection(value, place)
    if origin in (Union, types.UnionType):
        (inner,) = [argument for argument in arguments if argument is not type(None)]
        return None if value is None else _convert(inner, value, place)
    if origin is Literal:
        if value not in arguments:
            raise UserError(f"{place}: Invalid value {value!r}: choose one of {list(arguments)}.")
        return value
    if origin is list:
        if not isinstance(value, list) or not value:
            raise UserError(f"{place}: Invalid value {value!r}: use a list that is not empty.")
        return [_convert(arguments[0], item, f"{place}{_place(item, i)}") for i, item in enumerate(value)]
    if origin is dict:
        if not isinstance(value, dict) or not value:
            raise UserError(f"{place}: Invalid value {value!r}: use a mapping that is not empty.")
        return {str(key): _convert(arguments[1], item, f"{place}.{key}") for key, item in value.items()}
    if hasattr(kind, "__dataclass_fields__"):
        return _build(kind, value, place)
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        quoted = f', written as "{value}"' if kind is str and not isinstance(value, list | dict) else ""
        raise UserError(f"{place}: Invalid value {value!r}: use {KINDS[kind]}{quoted}.")
    return value


def _place(item: Any, index: int) -> str:
    """Return an item's index in a list, with its number, id or label if it has one."""
    name = (item.get("number") or item.get("id") or item.get("label")) if isinstance(item, dict) else None
    return f"[{index}]" if name is None else f"[{index}, {name}]"


def _selection(value: Any, place: str) -> dict[str, str]:
    if not isinstance(value, dict) or not all(isinstance(v, str | int | float) for v in value.values()):
        raise UserError(f"{place}: Invalid value {value!r}: use run parameters and their values.")
    return {str(key): str(item) for key, item in value.items()}
