"""Time methods frame by frame, under every backend: ``python benchmark.py --help``."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()


@hydra.main(config_path="conf", config_name="benchmark", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.benchmark import benchmark_command
    from supersampling.commands.entry import run

    run(benchmark_command, cfg)


if __name__ == "__main__":
    main()
