"""A run's scores as one Parquet table: every frame's, every clip's and every scene's value of every metric.

Columns are ``scene`` (text), ``clip`` and ``frame`` (integers, from 0), then one float64 column a metric. A row without
``frame`` is its clip's value, one without ``clip`` either is its scene's: a video metric has no value of a single frame,
so that clips do not follow from frames. NaN is no value (a temporal metric on a clip's first frame), infinity a value
(the PSNR of two equal images).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from supersampling.errors import UserError

FILE = "frames.parquet"
PLACE = ["scene", "clip", "frame"]


@dataclass(frozen=True)
class Scores:
    """Tables with the columns ``scene, clip, frame``, ``scene, clip`` and ``scene`` before those of the metrics."""

    frames: pd.DataFrame
    clips: pd.DataFrame
    scenes: pd.DataFrame

    @classmethod
    def of(cls, frames: pd.DataFrame, clips: pd.DataFrame) -> "Scores":
        """Scenes are means over their clips; clips without a value are left out."""
        metrics = clips.drop(columns=PLACE, errors="ignore").columns
        scenes = clips.groupby("scene", sort=False)[list(metrics)].mean().reset_index()
        return cls(frames, clips, scenes)


def write_scores(path: Path, scores: Scores) -> None:
    """Write the table; a metric that one level lacks has no value (NaN) there."""
    rows = pd.concat([scores.frames, scores.clips, scores.scenes], ignore_index=True)
    metrics = [str(name) for name in rows.columns if name not in PLACE]
    columns = {"scene": pa.array(rows["scene"].astype(str).tolist(), pa.string())}
    for name in PLACE[1:]:
        values = [None if pd.isna(value) else int(value) for value in rows[name]]
        columns[name] = pa.array(values, pa.int32())
    for name in metrics:
        columns[name] = pa.array(rows[name].to_numpy(dtype="float64"), pa.float64(), from_pandas=False)
    pq.write_table(pa.table(columns), path)


def read_scores(path: Path) -> Scores:
    """Read and check a table of `write_scores`; metrics without any value on a level are not in that level's table.

    Raises:
        UserError: not a Parquet file; columns or types that are missing or wrong; the same place twice; a clip with
            frames but without a value of its own.
    """
    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise UserError(f"'{path}' is not a Parquet table of scores: {str(error).splitlines()[0]}") from error
    metrics = [name for name in table.column_names if name not in PLACE]
    _check_columns(path, table, metrics)
    rows = table.to_pandas(types_mapper={pa.int32(): pd.Int32Dtype(), pa.int64(): pd.Int64Dtype()}.get)
    twice = rows[rows.duplicated(PLACE)]
    if len(twice):
        place = ", ".join(f"{name} {twice.iloc[0][name]}" for name in PLACE)
        raise UserError(f"'{path}' holds the same place twice ({place}): write the table again")
    has_clip, has_frame = rows["clip"].notna(), rows["frame"].notna()
    if (has_frame & ~has_clip).any():
        raise UserError(f"'{path}' holds a frame without its clip: write the table again")
    frames, clips = rows[has_frame], rows[has_clip & ~has_frame]
    missing = set(zip(frames["scene"], frames["clip"])) - set(zip(clips["scene"], clips["clip"]))
    if missing:
        scene, clip = min(missing)
        raise UserError(f"'{path}' lacks the row of clip {clip} of {scene}, whose frames it holds")
    scenes = rows[~has_clip]
    return Scores(*(_level(part, PLACE[:depth], metrics) for part, depth in ((frames, 3), (clips, 2), (scenes, 1))))


def _check_columns(path: Path, table: pa.Table, metrics: Sequence[str]) -> None:
    """Raise `UserError` unless the columns are a place and metrics."""
    missing = [name for name in PLACE if name not in table.column_names]
    if missing or not metrics:
        raise UserError(
            f"'{path}' has the columns {table.column_names}: it needs {', '.join(PLACE)} and at least one metric"
        )
    right: dict[str, Callable[[pa.DataType], bool]] = {
        "scene": lambda kind: pa.types.is_string(kind) or pa.types.is_large_string(kind),
        "clip": pa.types.is_integer,
        "frame": pa.types.is_integer,
    } | dict.fromkeys(metrics, pa.types.is_floating)
    for name, fits in right.items():
        kind = table.schema.field(name).type
        if not fits(kind):
            raise UserError(
                f"'{path}': column '{name}' holds {kind}, which is no {'metric' if name in metrics else name}"
            )


def _level(rows: pd.DataFrame, place: list[str], metrics: Sequence[str]) -> pd.DataFrame:
    present = [name for name in metrics if rows[name].notna().any()]
    plain = rows[[*place, *present]].astype(dict.fromkeys(place[1:], "int64"))
    return plain.reset_index(drop=True)
