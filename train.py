"""Train a method and log it: ``python train.py --help``."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.campaign import run_each
from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()


@hydra.main(config_path="conf", config_name="train", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.entry import run
    from supersampling.commands.train import train

    run(train, cfg)


if __name__ == "__main__":
    run_each(main, Path(os.environ["SUPERSAMPLING_ROOT"]) / "sweeps")
