"""Typeset a report from the MLflow runs: `python report.py --help`."""

import os
from pathlib import Path

import hydra
from omegaconf import DictConfig

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))


@hydra.main(version_base="1.3", config_path="conf", config_name="report")
def main(cfg: DictConfig) -> None:
    # Imported here so that --help is quick.
    from supersampling.commands.entry import run
    from supersampling.commands.report import write_report

    run(write_report, cfg)


if __name__ == "__main__":
    main()
