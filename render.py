"""Render data sets: ``python render.py --help``."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()


@hydra.main(config_path="conf", config_name="render", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.entry import run
    from supersampling.commands.render import render

    run(render, cfg)


if __name__ == "__main__":
    main()
