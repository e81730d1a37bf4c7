"""What an evaluation gives: every value of every frame, clip and scene, and crops, as files."""

import math
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from supersampling.evaluation.crops import file_name, save_crops, save_epipolar, strip
from supersampling.evaluation.protocol import Protocol
from supersampling.evaluation.score import ScoredFrame, evaluation_requires, score, whole_clips
from supersampling.metrics import scores
from supersampling.metrics.chosen import Metrics
from supersampling.metrics.video.epipolar import EpipolarPlane
from supersampling.models.base import Upsampler

PICTURES = ("crops", "epipolar", "state")


@dataclass(frozen=True)
class Result:
    """Tables by frame and by clip, ``scene, clip(, frame)`` before the metrics, and pictures of each scene's first clip."""

    frames: pd.DataFrame
    clips: pd.DataFrame
    pictures: tempfile.TemporaryDirectory

    @property
    def metrics(self) -> list[str]:
        """The columns of ``clips`` that are metrics and have a value."""
        return [str(m) for m in self.clips if m not in scores.PLACE and self.clips[m].notna().any()]

    def summary(self) -> dict[str, float]:
        """``test/<metric>`` over all clips and ``test/<scene>/<metric>`` for each scene, its ``/`` written ``_``."""
        means = {f"test/{m}": float(self.clips[m].mean()) for m in self.metrics}
        for scene, rows in self.clips.groupby("scene", sort=False):
            for m in self.metrics:
                value = float(rows[m].mean())
                if not math.isnan(value):
                    means[f"test/{file_name(str(scene))}/{m}"] = value
        return means

    def write(self, folder: Path) -> None:
        """``frames.parquet`` (see `supersampling.metrics.scores`), ``crops/``, ``crops.png``, ``epipolar/`` and ``state/``."""
        scores.write_scores(folder / scores.FILE, scores.Scores.of(self.frames, self.clips))
        for kind in PICTURES:
            shutil.copytree(Path(self.pictures.name) / kind, folder / kind)
        strip(folder / "crops").save(folder / "crops.png")

    def keep(self, older: scores.Scores) -> "Result":
        """With the metrics of an earlier evaluation of the same frames that this one did not compute."""
        return Result(_joined(self.frames, older.frames), _joined(self.clips, older.clips), self.pictures)


def _joined(ours: pd.DataFrame, older: pd.DataFrame) -> pd.DataFrame:
    place = [name for name in scores.PLACE if name in ours]
    more = [str(name) for name in older if name not in ours]
    return ours.merge(older[[*place, *more]], on=place, how="left") if more else ours


def evaluate(model: Upsampler, metrics: Metrics, protocol: Protocol, paths: list[Path]) -> Result:
    """Score ``model`` on whole test clips and keep crops and the epipolar image of each scene's first clip."""
    clips = whole_clips(paths, evaluation_requires(model, metrics), protocol.warm_up)
    return collect(score(model, metrics, protocol, clips), protocol.warm_up)


def collect(scored: Iterable[ScoredFrame], warm_up: int) -> Result:
    """The tables of scored frames. A clip's values are means over its frames after the warm-up, those without a value left out,
    and those of metrics of whole clips."""
    pictures = tempfile.TemporaryDirectory(prefix="pictures")
    folder = Path(pictures.name)
    for kind in PICTURES:
        (folder / kind).mkdir()
    rows: list[dict] = []
    of_clips: list[dict] = []
    scenes: list[str] = []
    plane = EpipolarPlane()
    for frame in scored:
        rows.append({**frame.place, **frame.scores})
        if frame.name.clip == 0:
            if frame.index == 0:
                plane = EpipolarPlane()
            plane.add(frame.output, frame.target)
        if frame.index < frame.length - 1:
            continue
        of_clips.append({"scene": frame.name.scene, "clip": frame.name.clip, **frame.clip_scores})
        if frame.name.clip == 0:
            save_crops(frame, folder, len(scenes))
            save_epipolar(plane, folder / "epipolar", f"{len(scenes)}_{file_name(frame.name.scene)}")
            scenes.append(frame.name.scene)
    frames = pd.DataFrame(rows)
    counted = frames[frames["frame"] >= warm_up].drop(columns="frame")
    means = counted.groupby(["scene", "clip"], sort=False).mean().reset_index()
    return Result(frames, means.merge(pd.DataFrame(of_clips), on=["scene", "clip"]), pictures)
