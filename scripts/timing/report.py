"""Seconds and memory of all reports on a synthetic store: ``python scripts/timing/report.py 1000``.

The store contains the runs that the cells, claims and figures of the papers select, with three seeds each, and variants
of them up to the requested number. Scores are random; their tables have the size of a small test set.
"""

import argparse
import hashlib
import resource
import tempfile
import time
from collections.abc import Iterator
from itertools import islice, product
from pathlib import Path

import numpy as np
import pandas as pd
from mlflow import MlflowClient
from mlflow.entities import Metric, Param
from omegaconf import OmegaConf

from supersampling.commands.report import report
from supersampling.metrics.scores import FILE, Scores, write_scores
from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.papers.schema import Paper, Selection
from supersampling.runs.location import uri_of_file

ROOT = Path(__file__).resolve().parents[2]
SCENES = [f"scene{index}" for index in range(9)]
STILL_METRICS = ["psnr", "ssim", "ssim_uniform11", "ssim_zero_pad11"]
METRICS = [*STILL_METRICS, "spatial", "temporal", "static_std", "psnr_disoccluded"]
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
    """Yield the parameters of ``count`` runs: three seeds of every selection, then of its next variant, and so on."""
    unique = [dict(item) for item in {tuple(sorted(s.items())): s for s in selections(papers)}.values()]
    runs = product(range(count), unique, range(3))
    for variant, selection, seed in islice(runs, count):
        yield {
            "model": "dlctus",
            "task.scale": "4",
            "task.mip_bias": "matched",
            "task.jitter": "thesis",
            "data": "laptop",
            "data.scenes": ",".join(SCENES),
            "budget": "laptop",
            "loss": "l1",
            "seed": str(seed),
            "model.variant": str(variant),
            **{f"budget.setting{index}": "1" for index in range(30)},
            **{name: value.split("|")[0] for name, value in selection.items()},
        }


def write_table(path: Path, seed: int, quality: float) -> None:
    """Write random scores of two clips of twelve frames per scene."""
    rng = np.random.default_rng(seed)
    indices = product(SCENES, range(2), range(12))
    frames = pd.DataFrame(indices, columns=["scene", "clip", "frame"])
    for name in METRICS:
        frames[name] = quality + rng.normal(scale=0.2, size=len(frames))
    write_scores(path, Scores.with_scene_means(frames, frames.groupby(["scene", "clip"])[METRICS].mean().reset_index()))


def fabricate(folder: Path, papers: list[Paper], count: int) -> None:
    """Create a store of ``count`` finished jobs in ``folder``."""
    uri = uri_of_file(folder / "mlflow.db")
    client = MlflowClient(uri)
    experiment = client.create_experiment("supersampling", (folder / "artifacts").as_uri())
    for index, params in enumerate(configurations(papers, count)):
        task = "/".join(value for name, value in sorted(params.items()) if name.startswith("task."))
        tags = {
            "ss.kind": "job",
            "ss.identity": f"{index:016x}",
            "ss.dataset": hashlib.sha256(task.encode()).hexdigest()[:16],
            "ss.method": params["model"],
            "ss.machine": "synthetic",
            "ss.version": "0",
        }
        run = client.create_run(experiment, run_name=f"run {index}", tags=tags).info
        learned = params["model"] not in CLASSICAL
        numbers = {"test/psnr": 30.0, "model/parameters": 1e5 * learned, "train/minutes": 3.0}
        numbers |= {f"test/{scene}/{name}": 0.5 for scene in SCENES for name in STILL_METRICS}
        client.log_batch(
            run.run_id,
            [Metric(name, value, 0, 0) for name, value in numbers.items()],
            [Param(name, value) for name, value in params.items()],
        )
        artifacts = folder / "artifacts" / run.run_id / "artifacts"
        artifacts.mkdir(parents=True)
        write_table(artifacts / FILE, index, 25.0 + index % 7)
        client.set_terminated(run.run_id, "FINISHED")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=1000)
    parser.add_argument("--store", type=Path, help="folder of the store, which is kept, or used if it exists")
    arguments = parser.parse_args()
    papers = load_papers(ROOT / "reports" / "published", None)
    with tempfile.TemporaryDirectory(prefix="benchmark-") as name:
        folder = arguments.store or Path(name)
        folder.mkdir(exist_ok=True)
        if not (folder / "mlflow.db").is_file():
            start = time.perf_counter()
            fabricate(folder, papers, arguments.runs)
            print(f"{arguments.runs} runs created in {time.perf_counter() - start:.0f} s", flush=True)
        measure(uri_of_file(folder / "mlflow.db"), Path(name) / "out")


def measure(uri: str, output: Path) -> None:
    folders = {name: str(ROOT / "reports" / name) for name in ("published", "templates")}
    options = {"tracking_uri": uri, "experiment_name": "supersampling", "output": str(output)}
    cfg = OmegaConf.create(options | folders | dict.fromkeys(("paper", "dataset", "budget")))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    start, processor = time.perf_counter(), time.process_time()
    written = report(cfg)
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    times = f"{seconds:.1f} s, of which {processor:.1f} s on a core"
    print(f"{len(written)} PDFs: {times}; peak {peak:.0f} MB ({before:.0f} MB before)")


if __name__ == "__main__":
    main()
