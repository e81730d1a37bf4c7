"""Seconds and memory of all reports over a made-up store: ``python benchmarks/report.py 1000``.

The store holds what every cell, claim and figure of the papers asks for, three seeds each, and variants of it up to the
number given. Scores are made up; their tables have the size of a small test set.
"""

import argparse
import hashlib
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from mlflow import MlflowClient
from mlflow.entities import Metric, Param
from omegaconf import OmegaConf

from supersampling.metrics.scores import FILE, Scores, write_scores
from supersampling.reporting.document import write_report
from supersampling.reporting.published import load_papers
from supersampling.reporting.schema import Paper, Selection

ROOT = Path(__file__).resolve().parents[1]
SCENES = [f"scene{index}" for index in range(9)]
METRICS = [
    "psnr",
    "ssim",
    "ssim_uniform11",
    "mssim_thesis",
    "spatial",
    "temporal",
    "static_std",
    "psnr_disoccluded",
]
CLASSICAL = ("bicubic", "jau", "tus")


def selections(papers: list[Paper]) -> Iterator[Selection]:
    for paper in papers:
        for table in paper.tables:
            for row in table.rows:
                for column in table.columns:
                    if row.select is not None and column.select is not None:
                        yield {**table.base, **row.select, **column.select}
        for claim in paper.claims:
            yield from claim.selections.values()
        for figure in paper.figures:
            yield from ({**figure.base, **series.select} for series in figure.series)


def configurations(papers: list[Paper], count: int) -> Iterator[dict[str, str]]:
    """Parameters of ``count`` runs: three seeds of every selection, then of every selection with another width, and so on."""
    wanted = [dict(item) for item in {tuple(sorted(s.items())): s for s in selections(papers)}.values()]
    made = 0
    for variant in range(count):
        for selection in wanted:
            for seed in range(3):
                if made == count:
                    return
                made += 1
                chosen = {name: value.split("|")[0] for name, value in selection.items()}
                yield {
                    "model": "dlctus", "task.scale": "4", "task.mip_bias": "matched", "task.jitter": "thesis", "data": "laptop",
                    "data.scenes": ",".join(SCENES), "budget": "laptop", "loss": "l1", "seed": str(seed),
                    "model.variant": str(variant), **{f"budget.setting{index}": "1" for index in range(30)}, **chosen,
                }  # fmt: skip


def table(path: Path, seed: int, quality: float) -> None:
    """Two clips of twelve frames for each scene."""
    rng = np.random.default_rng(seed)
    places = [(scene, clip, frame) for scene in SCENES for clip in range(2) for frame in range(12)]
    frames = pd.DataFrame(places, columns=["scene", "clip", "frame"])
    for name in METRICS:
        frames[name] = quality + rng.normal(scale=0.2, size=len(frames))
    write_scores(path, Scores.with_scene_means(frames, frames.groupby(["scene", "clip"])[METRICS].mean().reset_index()))


def fabricate(folder: Path, papers: list[Paper], count: int) -> None:
    """A store of ``count`` finished jobs in ``folder``."""
    uri = f"sqlite:///{folder / 'mlflow.db'}"
    client = MlflowClient(uri)
    experiment = client.create_experiment("supersampling", (folder / "artifacts").as_uri())
    for index, params in enumerate(configurations(papers, count)):
        task = "/".join(value for name, value in sorted(params.items()) if name.startswith("task."))
        tags = {
            "ss.kind": "job", "ss.identity": f"{index:016x}", "ss.dataset": hashlib.sha256(task.encode()).hexdigest()[:16],
            "ss.method": params["model"], "ss.machine": "made up", "ss.version": "0",
        }  # fmt: skip
        run = client.create_run(experiment, run_name=f"run {index}", tags=tags).info
        learned = params["model"] not in CLASSICAL
        numbers = {"test/psnr": 30.0, "model/parameters": 1e5 * learned, "train/minutes": 3.0}
        numbers |= {f"test/{scene}/{name}": 0.5 for scene in SCENES for name in METRICS[:4]}
        client.log_batch(
            run.run_id,
            [Metric(name, value, 0, 0) for name, value in numbers.items()],
            [Param(name, value) for name, value in params.items()],
        )
        artifacts = folder / "artifacts" / run.run_id / "artifacts"
        artifacts.mkdir(parents=True)
        table(artifacts / FILE, index, 25.0 + index % 7)
        client.set_terminated(run.run_id, "FINISHED")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=1000)
    parser.add_argument("--store", type=Path, help="keep the store in this folder, or measure the one that is there")
    arguments = parser.parse_args()
    papers = load_papers(ROOT / "reports" / "published", None)
    with tempfile.TemporaryDirectory(prefix="benchmark-") as name:
        folder = arguments.store or Path(name)
        folder.mkdir(exist_ok=True)
        if not (folder / "mlflow.db").is_file():
            start = time.perf_counter()
            fabricate(folder, papers, arguments.runs)
            print(f"{arguments.runs} runs made in {time.perf_counter() - start:.0f} s", flush=True)
        measure(f"sqlite:///{folder / 'mlflow.db'}", Path(name) / "out")


def measure(uri: str, output: Path) -> None:
    cfg = OmegaConf.create(
        {
            "tracking_uri": uri, "experiment": "supersampling", "paper": None, "output": str(output),
            "dataset": None, "budget": None, "published": str(ROOT / "reports" / "published"),
            "templates": str(ROOT / "reports" / "templates"),
        }
    )  # fmt: skip
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    start, processor = time.perf_counter(), time.process_time()
    written = write_report(cfg)
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{len(written)} PDFs: {seconds:.1f} s, of them {processor:.1f} s of a core; peak {peak:.0f} MB ({before:.0f} MB before)"
    )


if __name__ == "__main__":
    main()
