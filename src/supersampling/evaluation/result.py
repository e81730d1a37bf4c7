"""The result of an evaluation: the values of every frame, clip and scene, and pictures, as files."""

import math
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from supersampling.evaluation.crops import corner_of_crop, file_name, save_crops, save_epipolar, strip
from supersampling.evaluation.protocol import Protocol
from supersampling.evaluation.score import ScoredFrame, evaluation_requires, score, whole_clips
from supersampling.evaluation.steps import Steps
from supersampling.metrics import scores
from supersampling.metrics.selection import Metrics
from supersampling.metrics.video.epipolar import EpipolarPlane
from supersampling.models.base import Upsampler

PICTURES = ("crops", "epipolar", "state", "steps")


@dataclass(frozen=True)
class Result:
    """Tables by frame and by clip, with the columns ``scene, clip(, frame)`` first, and pictures of each scene's first
    clip."""

    frames: pd.DataFrame
    clips: pd.DataFrame
    pictures: tempfile.TemporaryDirectory

    @property
    def metrics(self) -> list[str]:
        """Return the columns of ``clips`` that are metrics and have a value."""
        return [str(m) for m in self.clips if m not in scores.PLACE and self.clips[m].notna().any()]

    def summary(self) -> dict[str, float]:
        """Return the means ``test/<metric>`` over all clips and ``test/<scene>/<metric>`` over those of each scene.

        A ``/`` in the name of a scene becomes ``_``.
        """
        means = {f"test/{m}": float(self.clips[m].mean()) for m in self.metrics}
        for scene, rows in self.clips.groupby("scene", sort=False):
            for m in self.metrics:
                value = float(rows[m].mean())
                if not math.isnan(value):
                    means[f"test/{file_name(str(scene))}/{m}"] = value
        return means

    def write(self, folder: Path) -> None:
        """Write ``frames.parquet`` (see `scores`), ``crops/``, ``crops.png``, ``epipolar/``, ``state/``, ``steps/``."""
        scores.write_scores(folder / scores.FILE, scores.Scores.with_scene_means(self.frames, self.clips))
        for kind in PICTURES:
            shutil.copytree(Path(self.pictures.name) / kind, folder / kind)
        strip(folder / "crops").save(folder / "crops.png")

    def merge(self, older: scores.Scores) -> "Result":
        """Return this result with the missing metrics of ``older``, an evaluation of the same frames."""
        return Result(_joined(self.frames, older.frames), _joined(self.clips, older.clips), self.pictures)


def _joined(newer: pd.DataFrame, older: pd.DataFrame) -> pd.DataFrame:
    place = [name for name in scores.PLACE if name in newer]
    missing = [str(name) for name in older if name not in newer]
    return newer.merge(older[[*place, *missing]], on=place, how="left") if missing else newer


def evaluate(model: Upsampler, metrics: Metrics, protocol: Protocol, paths: list[Path]) -> Result:
    """Score ``model`` on the whole clips of the test files ``paths``."""
    clips = whole_clips(paths, evaluation_requires(model, metrics), protocol.warm_up)
    return collect(score(model, metrics, protocol, clips), protocol.warm_up)


def collect(scored: Iterable[ScoredFrame], warm_up: int) -> Result:
    """Return the tables of scored frames, with crops and the epipolar image of each scene's first clip.

    A clip's values are the means over its frames after the warm-up, without frames that have no value, and the values
    of the metrics of whole clips.
    """
    pictures = tempfile.TemporaryDirectory(prefix="pictures")
    folder = Path(pictures.name)
    for kind in PICTURES:
        (folder / kind).mkdir()
    frame_rows: list[dict] = []
    clip_rows: list[dict] = []
    scenes: list[str] = []
    plane, steps = EpipolarPlane(), Steps()
    for frame in scored:
        frame_rows.append({**frame.place, **frame.scores})
        if frame.name.clip == 0:
            if frame.index == 0:
                plane, steps = EpipolarPlane(), Steps()
            plane.add(frame.output, frame.target)
            steps.add(frame)
        if frame.index < frame.length - 1:
            continue
        clip_rows.append({"scene": frame.name.scene, "clip": frame.name.clip, **frame.clip_scores})
        if frame.name.clip == 0:
            save_crops(frame, folder, len(scenes))
            stem = f"{len(scenes)}_{file_name(frame.name.scene)}"
            save_epipolar(plane, folder / "epipolar", stem)
            steps.save(folder / "steps", stem, *corner_of_crop(frame))
            scenes.append(frame.name.scene)
    frames = pd.DataFrame(frame_rows)
    counted = frames[frames["frame"] >= warm_up].drop(columns="frame")
    means = counted.groupby(["scene", "clip"], sort=False).mean().reset_index()
    return Result(frames, means.merge(pd.DataFrame(clip_rows), on=["scene", "clip"]), pictures)
