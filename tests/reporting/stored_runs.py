"""A store of runs as the trainer logs them, with made-up numbers, and what a report of it has to say."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mlflow import MlflowClient
from mlflow.entities import Metric, Param
from omegaconf import DictConfig, OmegaConf
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SCENES = ("atrium", "foundry", "stk/zengarden")
FINGERPRINT = "3fa9c07715d2e8b1"
CLASSICAL = {"bicubic": 29.99, "jau": 31.83, "tus_thesis": 32.9, "tus": 33.68}
STAGES = {
    "reproject": "bicubic9", "dilate": "none", "accumulate": "buffer", "pad": "jitter_aligned",
    "confine": "straight_through", "initialise": "balanced",
}  # fmt: skip


class Log:
    """Logs one job's run with made-up numbers around a mean PSNR; every method sees the same hard and easy clips."""

    def __init__(self, folder: Path) -> None:
        self.uri = f"sqlite:///{folder / 'mlflow.db'}"
        self.folder = folder
        self.client = MlflowClient(self.uri)
        self.experiment = self.client.create_experiment("supersampling", (folder / "artifacts").as_uri())

    def run(self, model: str, psnr: float, name: str, status: str = "FINISHED", clips: int = 4, **other: Any) -> str:
        params = {"model": model, "task.scale": 4, "task.mip_bias": "matched", "data": "laptop"}
        params["data.scenes"] = ",".join(SCENES)
        if model == "dlctus":
            params |= {f"model.{stage}": option for stage, option in STAGES.items()}
            params |= {"loss": "l1", "budget": "laptop", "seed": 0}
        if model in ("tus", "tus_thesis"):
            params |= {"model.reproject": "bicubic9", "model.dilate": "none", "model.rectify": "clamp_rgb"}
        params |= other.pop("params", {})
        tags = {
            "ss.kind": "job", "ss.identity": name, "ss.dataset": FINGERPRINT, "ss.method": model,
            "ss.machine": "Linux x86_64, 2 threads, torch 2.14.1", "ss.version": "0.1.0",
        } | other.pop("tags", {})  # fmt: skip
        run = self.client.create_run(self.experiment, run_name=name, tags=tags).info.run_id
        frames = _frames(psnr, clips, int(params.get("seed", 0)))
        table = (
            frames.groupby(["scene", "clip"], sort=False)[["psnr", "ssim", "ssim_zero_pad11", "spatial", "temporal"]]
            .mean()
            .reset_index()
        )
        self.client.log_table(run, table, "clips.json")
        self.client.log_table(run, frames, "frames.json")
        metrics = [Metric("test/psnr", float(table.psnr.mean()), 0, 0)]
        metrics.append(Metric("model/parameters", 80034.0 if model == "dlctus" else 0.0, 0, 0))
        if model == "dlctus":
            metrics.append(Metric("train/minutes", 3.25, 0, 0))
            for epoch in range(6):
                metrics.append(Metric("train/loss", 0.05 / (1 + epoch), 0, epoch))
                metrics.append(Metric("val/psnr", psnr - 3 / (1 + epoch), 0, epoch))
        self.client.log_batch(run, metrics, [Param(key, str(value)) for key, value in params.items()])
        self._crops(run, psnr)
        self._epipolar(run, psnr)
        self.client.set_terminated(run, status)
        return run

    def _crops(self, run: str, psnr: float) -> None:
        folder = self.folder / "crops"
        folder.mkdir(exist_ok=True)
        for index, scene in enumerate(SCENES):
            rng = np.random.default_rng(index)
            y, x = np.mgrid[0:96, 0:96] / 96
            wave = np.stack([np.sin(9 * x * (1 + c) + index) * np.cos(23 * y * x) for c in range(3)], axis=-1)
            target = 128 + 90 * wave
            noise = rng.normal(size=target.shape) * (x > 0.5)[..., None] * 255 * 10 ** (-psnr / 20)
            raw = target[::4, ::4].repeat(4, axis=0).repeat(4, axis=1)
            for suffix, image in (("", target + noise), ("_target", target), ("_input", raw)):
                path = folder / f"{index}_{scene.replace('/', '_')}{suffix}.png"
                Image.fromarray(np.clip(image, 0, 255).astype(np.uint8)).save(path)
        self.client.log_artifacts(run, str(folder), "crops")
        shutil.rmtree(folder)

    def _epipolar(self, run: str, psnr: float) -> None:
        """A clip that stands still, with noise on its right half."""
        folder = self.folder / "epipolar"
        folder.mkdir(exist_ok=True)
        for index, scene in enumerate(SCENES):
            row = 128 + 90 * np.sin(np.arange(200) / (3 + index))
            target = np.broadcast_to(row[None, :, None], (24, 200, 3))
            noise = np.random.default_rng(index).normal(size=target.shape) * 255 * 10 ** (-psnr / 20)
            noise[:, :100] = 0
            for suffix, image in (("", target + noise), ("_target", target)):
                path = folder / f"{index}_{scene.replace('/', '_')}{suffix}.png"
                Image.fromarray(np.clip(image, 0, 255).astype(np.uint8)).save(path)
        self.client.log_artifacts(run, str(folder), "epipolar")
        shutil.rmtree(folder)


def _frames(psnr: float, clips: int, seed: int) -> pd.DataFrame:
    rows = []
    for s, scene in enumerate(SCENES):
        for clip in range(clips):
            rng = np.random.default_rng([s, clip])
            hardness, rng = rng.normal(scale=2.5), np.random.default_rng([s, clip, seed, int(100 * psnr)])
            for frame in range(12):
                p = psnr + hardness + rng.normal(scale=0.2) + 2 * min(frame, 6) / 6 - 1.5
                ssim = 1 - 10 ** (-p / 30)
                rows.append((scene, clip, frame, p, ssim, ssim - 0.02, 10 ** (-p / 20), 0.3 * 10 ** (-p / 20)))
    return pd.DataFrame(
        rows, columns=["scene", "clip", "frame", "psnr", "ssim", "ssim_zero_pad11", "spatial", "temporal"]
    )


def config(log: Log, output: Path, **more: Any) -> DictConfig:
    cfg = OmegaConf.load(ROOT / "conf" / "report.yaml")
    del cfg["defaults"], cfg["hydra"]
    settings = {"tracking_uri": log.uri, "experiment_name": "supersampling", "output": str(output), "paper": "dlctus"}
    return OmegaConf.merge(cfg, {**settings, **more})  # type: ignore[return-value]


def ours(report: Path, table: int) -> pd.DataFrame:
    return pd.read_csv(report / f"dlctus_table{table}.csv").set_index(["row", "column", "metric"])


def mean_of(log: Log, metric: str, names: tuple[str, ...]) -> float:
    """The truth of a cell, by hand: mean over the named runs of the mean over their clips."""
    runs = log.client.search_runs([log.experiment])
    paths = [log.client.download_artifacts(r.info.run_id, "clips.json") for r in runs if r.info.run_name in names]
    assert len(paths) == len(names)
    tables = [json.loads(Path(path).read_text()) for path in paths]
    return float(np.mean([[row[t["columns"].index(metric)] for row in t["data"]] for t in tables]))
