"""A paper's own numbers and claims: the checked contents of ``reports/published/<paper>.yaml``."""

import re
import types
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import yaml

from supersampling.errors import UserError
from supersampling.reporting.papers.schema import BY_NUMBER, Claim, Paper, PublishedFigure, PublishedTable, Selection

NUMBER = re.compile(r"[A-Z]?\d+[a-z]?")  # 2, or S2 of a supplement
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's is ten times faster
T = TypeVar("T")


def load_papers(folder: Path, name: str | None) -> list[Paper]:
    """The paper ``name``, or every paper of the folder by name."""
    if name is not None:
        return [load_paper(folder / f"{name}.yaml")]
    paths = sorted(folder.glob("*.yaml"))
    if not paths:
        raise UserError(f"there are no published numbers in '{folder}': set published to a folder that has them")
    return [load_paper(path) for path in paths]


def load_paper(path: Path) -> Paper:
    """Read and check ``path``; whatever is missing, unknown or of the wrong type raises `UserError` with its place."""
    if not path.is_file():
        raise UserError(f"there are no published numbers at '{path}': choose a paper that has a file there")
    try:
        raw = yaml.load(path.read_text(encoding="utf-8"), LOADER)
    except yaml.YAMLError as error:
        raise UserError(f"'{path}' is not valid YAML: {error}") from error
    paper = _build(Paper, raw, str(path))
    _check_places(paper, str(path))
    for table in paper.tables:
        _check_table(table, paper, f"{path}: table {table.number}")
    for fact in paper.facts:
        for row in fact.rows:
            if len(row) != len(fact.headers):
                raise UserError(f"{path}: facts {fact.number}: row {row} must have a cell for each of {fact.headers}")
    for figure in paper.figures:
        _check_figure(figure, f"{path}: figure {figure.number}")
    for claim in paper.claims:
        _check_claim(claim, paper, f"{path}: claim {claim.id}")
    return paper


def name_of(number: str, kind: str = "Table") -> str:
    """``Table 2``; a remark of the text, which has no number, goes by its own name."""
    return f"{kind} {number}" if NUMBER.fullmatch(number) else number[:1].upper() + number[1:]


def stem_of(number: str) -> str:
    """What stands for a table's or figure's number in file names."""
    return re.sub(r"\W+", "_", number)


def sweep_of(table: PublishedTable, paper: Paper) -> str | None:
    """The name in ``sweeps/`` of what runs a table's rows."""
    return f"{paper.paper}_table{table.number}" if table.file == BY_NUMBER else table.file


def _check_places(paper: Paper, path: str) -> None:
    """Numbers and ids occur once, pages count from 1."""
    named: dict[str, Sequence[Any]] = {
        "table numbers": paper.tables, "facts' numbers": paper.facts, "figure numbers": paper.figures,
    }  # fmt: skip
    for what, items in named.items():
        _check_unique((item.number for item in items), f"{path}: {what}")
    _check_unique((claim.id for claim in paper.claims), f"{path}: claims' ids")
    places = [
        (item.number, item.page)
        for items in (paper.tables, paper.facts, paper.pictures, paper.figures)
        for item in items
    ]
    for name, page in [*places, *((claim.id, claim.page) for claim in paper.claims)]:
        if page < 0:
            raise UserError(f"{path}: the page of '{name}' must be 1 or more, 0 if unknown, got {page}")


def _check_unique(values: Iterable[str], where: str) -> None:
    found = list(values)
    twice = sorted({value for value in found if found.count(value) > 1})
    if twice:
        raise UserError(f"{where} must be unique, got {', '.join(twice)} more than once")


def _check_table(table: PublishedTable, paper: Paper, where: str) -> None:
    for column in table.columns:
        unknown = [name for name in column.metrics if name not in paper.metrics]
        if unknown or not column.metrics:
            raise UserError(
                f"{where}: column '{column.label}' has metrics {column.metrics}, known are {list(paper.metrics)}"
            )
    expected = [len(column.metrics) for column in table.columns]
    if table.compare == "row" and len(set(map(tuple, (column.metrics for column in table.columns)))) != 1:
        raise UserError(f"{where}: columns compared along a row must have the same metrics")
    for row in table.rows:
        if [len(values) for values in row.values] != expected:
            raise UserError(f"{where}: row {row.labels} must hold {expected} numbers by column, got {row.values}")
        if len(row.labels) != len(table.headers):
            raise UserError(f"{where}: row {row.labels} must have one label for each of {table.headers}")
        if not table.lost and any(value is None for values in row.values for value in values):
            raise UserError(f"{where}: row {row.labels} has a null, so `lost` must say what is missing and why")


def _check_figure(figure: PublishedFigure, where: str) -> None:
    if figure.kind in ("curve", "front") and figure.x is None:
        raise UserError(f"{where}: a {figure.kind} needs x, a run parameter or metric, or 'frame' for a curve")
    _check_unique((series.label for series in figure.series), f"{where}: series' labels")


def _check_claim(claim: Claim, paper: Paper, where: str) -> None:
    if not claim.id.startswith(f"{paper.paper}-"):
        raise UserError(f"{where}: its id must begin with '{paper.paper}-'")
    if claim.stepwise:
        if len(claim.steps) < 2:
            raise UserError(f"{where}: kind '{claim.kind}' needs at least two steps")
        if claim.a not in (None, claim.steps[-1].select) or claim.b not in (None, claim.steps[0].select):
            raise UserError(f"{where}: a must be the last step and b the first, or both left away")
        _check_unique((step.label for step in claim.steps), f"{where}: steps' labels")
    elif claim.a is None or claim.b is None or claim.steps:
        raise UserError(f"{where}: kind '{claim.kind}' needs a and b, and no steps")
    elif claim.a == claim.b:
        raise UserError(f"{where}: a and b are the same selection")
    if (claim.kind == "same") != (claim.margin is not None) or (claim.margin is not None and claim.margin <= 0):
        raise UserError(
            f"{where}: kind 'same' needs a margin above 0, others have none, got margin {claim.margin} of '{claim.kind}'"
        )

    if claim.times != 1.0 and not (claim.times > 1.0 and claim.kind == "less" and claim.metric.startswith("run:")):
        raise UserError(
            f"{where}: times is a factor above 1 of a logged number that is less, got {claim.times:g} of '{claim.kind}'"
        )


def _build(cls: type[T], raw: Any, where: str) -> T:
    """A dataclass from a mapping, recursively."""
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    if not isinstance(raw, dict):
        raise UserError(f"{where}: expected a mapping with {list(known)}, got {raw!r}")
    unknown = sorted(set(map(str, raw)) - set(known))
    if unknown:
        raise UserError(f"{where}: unknown keys {unknown}, known are {sorted(known)}")
    optional = {name for name, f in known.items() if f.default is not MISSING or f.default_factory is not MISSING}
    missing = sorted(set(known) - optional - set(raw))
    if missing:
        raise UserError(f"{where}: missing keys {missing}")
    values = {}
    for name, value in raw.items():
        if value == [] and name in optional:
            values[name] = value
        else:
            values[name] = _convert(known[name].type, value, f"{where}: {name}")
    return cls(**values)


def _convert(kind: Any, value: Any, where: str) -> Any:
    """``value`` checked against an annotation of the schema's dataclasses."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind == Selection:
        return _selection(value, where)
    if origin in (Union, types.UnionType):
        (inner,) = [argument for argument in arguments if argument is not type(None)]
        return None if value is None else _convert(inner, value, where)
    if origin is Literal:
        if value not in arguments:
            raise UserError(f"{where}: expected one of {list(arguments)}, got {value!r}")
        return value
    if origin is list:
        if not isinstance(value, list) or not value:
            raise UserError(f"{where}: expected a list that is not empty, got {value!r}")
        return [_convert(arguments[0], item, f"{where}{_place(item, i)}") for i, item in enumerate(value)]
    if origin is dict:
        if not isinstance(value, dict) or not value:
            raise UserError(f"{where}: expected a mapping that is not empty, got {value!r}")
        return {str(key): _convert(arguments[1], item, f"{where}.{key}") for key, item in value.items()}
    if hasattr(kind, "__dataclass_fields__"):
        return _build(kind, value, where)
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or isinstance(value, bool):
        quoted = f': write it as "{value}"' if kind is str and not isinstance(value, list | dict) else ""
        raise UserError(f"{where}: expected {kind.__name__}, got {value!r}{quoted}")
    return value


def _place(item: Any, index: int) -> str:
    """Where in a list: its index, and its number or id if it has one."""
    name = (item.get("number") or item.get("id") or item.get("label")) if isinstance(item, dict) else None
    return f"[{index}]" if name is None else f"[{index}, {name}]"


def _selection(value: Any, where: str) -> dict[str, str]:
    if not isinstance(value, dict) or not all(isinstance(v, str | int | float) for v in value.values()):
        raise UserError(f"{where}: expected run parameters and their values, got {value!r}")
    return {str(key): str(item) for key, item in value.items()}
