"""Export a trained method to ONNX: ``python export.py --help``."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()


@hydra.main(config_path="conf", config_name="export", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.entry import run
    from supersampling.commands.export import export_command

    run(export_command, cfg)


if __name__ == "__main__":
    main()
