"""Count a method's parameters and multiply-accumulates: ``python count.py --help``."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()


@hydra.main(config_path="conf", config_name="count", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.count import count_command
    from supersampling.commands.entry import run

    run(count_command, cfg)


if __name__ == "__main__":
    main()
