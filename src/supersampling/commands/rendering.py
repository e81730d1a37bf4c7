"""Time of the renderer for the methods of a benchmark."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from omegaconf import DictConfig

from supersampling.errors import UserError
from supersampling.runs.subjects import Subject
from supersampling.scenes.load import check_scene, load_scene

SHOWN = ["method", "part", "scale", "width", "height", "ms", "low", "high", "frames", "buffers"]


def rendered_scenes(cfg: DictConfig) -> list[str]:
    """Return the names of the scenes to render, none unless ``rendering`` is set.

    Raises:
        UserError: a scene does not exist, or there is none.
    """
    if not cfg.rendering:
        return []
    names = [cfg.scene] if isinstance(cfg.scene, str) else list(cfg.scene)
    if not names:
        raise UserError("Empty scene=[] with rendering=true: use for example scene=atrium.")
    if "gltf" in names and not cfg.path:
        raise UserError("Missing path for scene=gltf: add path=FILE.gltf or path=FILE.glb.")
    names = [f"gltf/{Path(cfg.path).stem}" if name == "gltf" else name for name in names]
    for name in names:
        check_scene(name)
    return names


def renderings(cfg: DictConfig, subjects: Sequence[Subject], scenes: Sequence[str]) -> pd.DataFrame:
    """Return the renderer's times for these scenes, and print them."""
    if not scenes:
        return pd.DataFrame()
    from supersampling.profiling.rendering import rendering_table  # OpenGL is needed only here

    tables = []
    for name in scenes:
        scene = load_scene(name, Path(cfg.path) if cfg.path else None)
        tables.append(rendering_table(scene, subjects, cfg.sizes, cfg.frames, float(cfg.seconds)))
        print(f"\n{name}, rendered by {tables[-1].renderer[0]}; milliseconds per frame")
        print(tables[-1][SHOWN].to_string(index=False, float_format="{:.2f}".format))
    return pd.concat(tables, ignore_index=True)
