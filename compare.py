"""Compare two methods over the same clips: `python compare.py --help`."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))


@hydra.main(version_base="1.3", config_path="conf", config_name="compare")
def main(cfg: DictConfig) -> None:
    # Imported here so that --help is quick.
    from supersampling.commands.compare import compare_command
    from supersampling.commands.entry import run

    run(compare_command, cfg)


if __name__ == "__main__":
    main()
