"""A run's scores as one Parquet table: the values of all metrics for every frame, every clip and every scene.

Columns are ``scene`` (text), ``clip`` and ``frame`` (integers, from 0), then one float64 column per metric. A row
without ``frame`` holds the values of its clip, a row without ``clip`` and ``frame`` those of its scene: clips cannot be
computed from frames, because a video metric has no value for a single frame. NaN means no value (a temporal metric on a
clip's first frame); infinity is a value (an uncapped PSNR of two equal images).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from supersampling.errors import UserError, describe_system_error, first_line
from supersampling.files import check_regular_file

FILE = "frames.parquet"
PLACE = ["scene", "clip", "frame"]


@dataclass(frozen=True)
class Scores:
    """The tables of a run: columns ``scene, clip, frame``, ``scene, clip`` and ``scene``, then those of the metrics."""

    frames: pd.DataFrame
    clips: pd.DataFrame
    scenes: pd.DataFrame

    @classmethod
    def with_scene_means(cls, frames: pd.DataFrame, clips: pd.DataFrame) -> "Scores":
        """Return scores whose scenes are means over their clips; clips without a value are left out."""
        metrics = clips.drop(columns=PLACE, errors="ignore").columns
        scenes = clips.groupby("scene", sort=False)[list(metrics)].mean().reset_index()
        return cls(frames, clips, scenes)


def write_scores(path: Path, scores: Scores) -> None:
    """Write the table; a metric that is missing in a level has no value (NaN) there."""
    rows = pd.concat([scores.frames, scores.clips, scores.scenes], ignore_index=True)
    metrics = [str(name) for name in rows.columns if name not in PLACE]
    columns = {"scene": pa.array(rows["scene"].astype(str).tolist(), pa.string())}
    for name in PLACE[1:]:
        values = [None if pd.isna(value) else int(value) for value in rows[name]]
        columns[name] = pa.array(values, pa.int32())
    for name in metrics:
        columns[name] = pa.array(rows[name].to_numpy(dtype="float64"), pa.float64(), from_pandas=False)
    pq.write_table(pa.table(columns), path, write_page_checksum=True)


def read_scores(path: Path) -> Scores:
    """Read and check a table of `write_scores`; metrics without any value in a level are not in the table of that
    level.

    Raises:
        UserError: the file is not Parquet; columns are missing or of a wrong type; two rows have the same place; a clip
            has frames but no row for the clip.
    """
    check_regular_file(path)
    try:
        table = pq.read_table(path, page_checksum_verification=True)
    except (pa.ArrowException, OSError) as error:
        if isinstance(error, OSError) and (condition := describe_system_error(error, path)):
            raise condition from error
        raise UserError(f"{path} is not a Parquet table of scores ({first_line(error)}): write it again.") from error
    metrics = [name for name in table.column_names if name not in PLACE]
    _check_columns(path, table, metrics)
    rows = table.to_pandas(types_mapper={pa.int32(): pd.Int32Dtype(), pa.int64(): pd.Int64Dtype()}.get)
    duplicates = rows[rows.duplicated(PLACE)]
    if len(duplicates):
        place = ", ".join(f"{name} {duplicates.iloc[0][name]}" for name in PLACE)
        raise UserError(f"Two rows of {path} have the same place ({place}): write the table again.")
    has_clip, has_frame = rows["clip"].notna(), rows["frame"].notna()
    if (has_frame & ~has_clip).any():
        raise UserError(f"A row of {path} has a frame but no clip: write the table again.")
    frames, clips = rows[has_frame], rows[has_clip & ~has_frame]
    missing = set(zip(frames["scene"], frames["clip"])) - set(zip(clips["scene"], clips["clip"]))
    if missing:
        scene, clip = min(missing)
        raise UserError(f"{path} has frames of clip {clip} of {scene} but no row for the clip: write the table again.")
    scenes = rows[~has_clip]
    return Scores(*(_level(part, PLACE[:depth], metrics) for part, depth in ((frames, 3), (clips, 2), (scenes, 1))))


def _check_columns(path: Path, table: pa.Table, metrics: Sequence[str]) -> None:
    """Raise `UserError` unless the columns are those of a place and of at least one metric, each of its type."""
    missing = [name for name in PLACE if name not in table.column_names]
    if missing or not metrics:
        raise UserError(
            f"Invalid columns {', '.join(table.column_names)} of {path}: write the table again, with "
            f"{', '.join(PLACE)} and at least one metric."
        )
    checks: dict[str, Callable[[pa.DataType], bool]] = {
        "scene": lambda kind: pa.types.is_string(kind) or pa.types.is_large_string(kind),
        "clip": pa.types.is_integer,
        "frame": pa.types.is_integer,
    } | dict.fromkeys(metrics, pa.types.is_floating)
    for name, fits in checks.items():
        kind = table.schema.field(name).type
        if not fits(kind):
            raise UserError(
                f"Column {name} of {path} has the invalid type {kind} for a {'metric' if name in metrics else name}: "
                "write the table again."
            )


def _level(rows: pd.DataFrame, place: list[str], metrics: Sequence[str]) -> pd.DataFrame:
    present = [name for name in metrics if rows[name].notna().any()]
    plain = rows[[*place, *present]].astype(dict.fromkeys(place[1:], "int64"))
    return plain.reset_index(drop=True)
