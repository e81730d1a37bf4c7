"""Made-up benchmarks: the commands of the papers' tables with their methods' real parts, and a number for each part."""

import shlex
from functools import cache
from zlib import crc32

import pandas as pd
import torch
import yaml
from hydra.utils import instantiate
from omegaconf import OmegaConf

from supersampling.config import composed
from supersampling.models.base import Upsampler
from supersampling.models.count import count_modules, random_frame
from supersampling.models.dlctus_inference import DLCTUSForInference, DLCTUSWithoutShuffle
from supersampling.profiling.parts import Recorder, measure_parts
from supersampling.runs import subjects
from supersampling.runs.store import Run
from supersampling.runs.timing import architecture

SMALL = (64, 32)  # target pixels
FORMS = {"thesis_1": DLCTUSWithoutShuffle, "thesis_1_2": DLCTUSForInference}
MACHINE = "Linux x86_64, 2 threads, torch 2.14.1"
RENDERED = ("render", "render.g_buffers", "render.high")


def number(*place: object) -> float:
    """Return a number of milliseconds between 1 and 1001 that tells its place."""
    return 1 + crc32(repr(place).encode()) % 1_000_000 / 1000


@cache
def subject(name: str, scale: int) -> tuple[dict, dict, str]:
    """Return a method's configuration, parameters and architecture, composed without a command line."""
    cfg = composed("benchmark", [f"task.scale={scale}", *subjects._overrides(name)])
    model = OmegaConf.to_container(cfg.cfg.model, resolve=True)
    return model, subjects._parameters(cfg.cfg, cfg.choices), architecture(model, scale)


@cache
def parts_of(name: str, form: str, depth: int) -> tuple[str, ...]:
    """Return the names of the parts that a small frame of the real method has, at every scale the same."""
    model: Upsampler = instantiate(subject(name, 4)[0]).eval()
    if form:
        model = FORMS[form](model)
    frame = random_frame(model, SMALL[0] // 4, SMALL[1] // 4, "cpu")
    with torch.no_grad():
        state = model(frame, None)[1]
        step = lambda: model.present(model(frame, state)[0], frame)  # noqa: E731
        return tuple(part.part for part in measure_parts(model, step, 1, Recorder(torch.device("cpu"), depth)))


@cache
def modules_of(name: str, scale: int, depth: int) -> list:
    model: Upsampler = instantiate(subject(name, scale)[0])
    return count_modules(model, 1920 // scale, 1080 // scale, depth)


class MadeUpStore:
    """A store of benchmarks, each with the tables that its command logs; the last one is the newest."""

    def __init__(self, *commands: str) -> None:
        self.tables = [self._tables(command) for command in commands]
        self.runs = [
            Run(
                id=f"bench{index}", name="benchmark", identity=f"bench{index}", dataset="unknown", method="unknown",
                machine=MACHINE, version="0.1.0", ended=1000 + index, params={}, metrics={}, kind="benchmark",
            )
            for index in range(len(commands))
        ]  # fmt: skip

    def logged(self, experiment_id: str, kind: str, name: str) -> list[tuple[Run, pd.DataFrame]]:
        assert kind == "benchmark"
        return [(run, tables[name]) for run, tables in zip(self.runs, self.tables) if name in tables]

    def _tables(self, command: str) -> dict[str, pd.DataFrame]:
        settings = {"scales": [4], "sizes": [[1920, 1080]], "depth": 1, "rendering": False, "precisions": ["float32"]}
        words = [word.partition("=") for word in shlex.split(command)[2:]]
        settings |= {key: yaml.safe_load(value) for key, _, value in words}
        rows = {f"{name}.json": [] for name in ("timings", "stages", "parameters", "modules", "renderings")}
        for name in settings["methods"]:
            for scale in settings["scales"]:
                _, parameters, key = subject(name, scale)
                rows["parameters.json"] += [{"architecture": key, "name": k, "value": v} for k, v in parameters.items()]
                for width, height in settings["sizes"]:
                    self._add(rows, settings, (name, scale, width, height))
        for width, height in settings["sizes"] if settings["rendering"] else []:
            place = {"architecture": "", "part": "render", "scale": 1, "width": width, "height": height}
            rows["renderings.json"] += self._rendered(place, "full")
        return {name: pd.DataFrame(content) for name, content in rows.items() if content}

    def _rendered(self, place: dict, name: str) -> list[dict]:
        """Two scenes, whose mean is the number."""
        size = f"{place['width']}x{place['height']}"
        ms = number(name, place["scale"], size, place["part"])
        scenes = {"atrium": -0.5, "bar": 0.5}
        return [{**place, "ms": ms + d, "scene": scene, "renderer": "llvmpipe"} for scene, d in scenes.items()]

    def _add(self, rows: dict, settings: dict, place: tuple) -> None:
        name, scale, width, height = place
        _, _, key = subject(name, scale)
        size = f"{width}x{height}"
        for backend in settings["backends"]:
            for precision in settings["precisions"]:
                identity = {
                    "method": name, "architecture": key, "scale": scale, "width": width, "height": height,
                    "backend": backend, "precision": precision, "device": "cpu", "threads": 2, "machine": MACHINE,
                }  # fmt: skip
                at = (name, scale, size, backend, precision)
                numbers = {"ms": number(*at, "whole"), "parameters": 7, "gmac": 0.5, "why": ""}
                rest = dict.fromkeys(("low", "high", "peak_mb", "gbytes", "of_product", "of_copy"), 0.0) | {"frames": 5}
                rows["timings.json"].append({**identity, **numbers, **rest})
                if backend not in ("onnxruntime", "openvino"):
                    parts = parts_of(name, backend if backend in FORMS else "", settings["depth"])
                    rows["stages.json"] += [{**identity, "part": p, "ms": number(*at, p)} for p in parts]
        if name == "nsrd":
            rows["modules.json"] += [
                {
                    "architecture": key, "width": width, "height": height, "module": m.module,
                    "parameters": m.parameters, "gmac": m.macs / 1e9,
                }
                for m in modules_of(name, scale, settings["depth"])
            ]  # fmt: skip
        for part in RENDERED if settings["rendering"] else ():
            rows["renderings.json"] += self._rendered(
                {"architecture": key, "part": part, "scale": scale, "width": width, "height": height}, name
            )
