"""A paper's own numbers: the checked contents of ``reports/published/<paper>.yaml``."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

import yaml

from supersampling.errors import UserError

Selection = Mapping[str, str]
T = TypeVar("T")


@dataclass(frozen=True)
class Metric:
    """A printed quantity; ``ours`` is the column of our clip tables that holds it, times ``factor``."""

    label: str
    unit: str
    better: Literal["higher", "lower"]
    decimals: int
    ours: str
    factor: float = 1.0


@dataclass(frozen=True)
class Column:
    """A column; ``select`` is ``None`` for a method that we lack."""

    label: str
    select: Selection | None
    metrics: list[str]


@dataclass(frozen=True)
class Row:
    """A row; ``values[c][m]`` is the published number of column ``c``'s ``m``-th metric."""

    labels: list[str]
    select: Selection
    values: list[list[float]]


@dataclass(frozen=True)
class PublishedTable:
    """One table of a paper, and how to find our runs for its cells."""

    number: int
    section: str
    page: int
    title: str
    compare: Literal["row", "column"]
    headers: list[str]
    base: Selection
    columns: list[Column]
    rows: list[Row]
    note: str = ""
    prefer: Selection | None = None


@dataclass(frozen=True)
class Paper:
    """A paper's tables in its own order."""

    paper: str
    title: str
    authors: str
    source: str
    short: str
    metrics: dict[str, Metric]
    tables: list[PublishedTable]


def load_paper(path: Path) -> Paper:
    """Read and check ``path``; whatever is missing, unknown or of the wrong type raises `UserError` with its place."""
    if not path.is_file():
        raise UserError(f"there are no published numbers at '{path}': choose a paper that has a file there")
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise UserError(f"'{path}' is not valid YAML: {error}") from error
    paper = _build(Paper, raw, str(path))
    numbers = [table.number for table in paper.tables]
    if len(set(numbers)) != len(numbers):
        raise UserError(f"{path}: table numbers must be unique, got {numbers}")
    for table in paper.tables:
        _check_table(table, paper, f"{path}: table {table.number}")
    return paper


def _check_table(table: PublishedTable, paper: Paper, where: str) -> None:
    if table.number < 1 or table.page < 1:
        raise UserError(f"{where}: number and page must be at least 1, got {table.number} and {table.page}")
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
            raise UserError(
                f"{where}: row {row.labels} must hold {expected} numbers by column, got {row.values}"
            )
        if len(row.labels) != len(table.headers):
            raise UserError(f"{where}: row {row.labels} must have one label for each of {table.headers}")


def _build(cls: type[T], raw: Any, where: str) -> T:
    """A dataclass from a mapping, recursively."""
    if not isinstance(raw, dict):
        raise UserError(f"{where}: expected a mapping with {[f.name for f in fields(cls)]}, got {raw!r}")  # type: ignore[arg-type]
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    unknown = sorted(set(map(str, raw)) - set(known))
    if unknown:
        raise UserError(f"{where}: unknown keys {unknown}, known are {sorted(known)}")
    required = {name for name, f in known.items() if f.default is f.default_factory}
    missing = sorted(required - set(raw))
    if missing:
        raise UserError(f"{where}: missing keys {missing}")
    return cls(**{name: _convert(known[name].type, value, f"{where}: {name}") for name, value in raw.items()})


def _convert(kind: Any, value: Any, where: str) -> Any:
    """``value`` checked against an annotation of this file's dataclasses."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind == Selection:
        return _selection(value, where)
    if kind == Selection | None:
        return None if value is None else _selection(value, where)
    if origin is Literal:
        if value not in arguments:
            raise UserError(f"{where}: expected one of {list(arguments)}, got {value!r}")
        return value
    if origin is list:
        if not isinstance(value, list) or not value:
            raise UserError(f"{where}: expected a list that is not empty, got {value!r}")
        return [_convert(arguments[0], item, f"{where}[{i}]") for i, item in enumerate(value)]
    if origin is dict:
        if not isinstance(value, dict) or not value:
            raise UserError(f"{where}: expected a mapping that is not empty, got {value!r}")
        return {str(key): _convert(arguments[1], item, f"{where}.{key}") for key, item in value.items()}
    if hasattr(kind, "__dataclass_fields__"):
        return _build(kind, value, where)
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise UserError(f"{where}: expected {kind.__name__}, got {value!r}")
    return value


def _selection(value: Any, where: str) -> dict[str, str]:
    if not isinstance(value, dict) or not all(isinstance(v, str | int | float) for v in value.values()):
        raise UserError(f"{where}: expected run parameters and their values, got {value!r}")
    return {str(key): str(item) for key, item in value.items()}
