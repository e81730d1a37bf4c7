"""Try every model at the extremes: ``python stress.py --help``.

The exit status is 0 where all stated tolerances hold, 3 where one does not, and 2 where the command cannot be done.
"""

import os
import sys
from pathlib import Path

import hydra
from omegaconf import DictConfig

from supersampling.commands.resolvers import register

os.environ.setdefault("SUPERSAMPLING_ROOT", str(Path(__file__).resolve().parent))
register()

TOLERANCE_STATUS = 3


@hydra.main(config_path="conf", config_name="stress", version_base="1.3")
def main(cfg: DictConfig) -> None:
    from supersampling.commands.entry import run
    from supersampling.commands.stress import stress_command

    held: list[bool] = []
    run(lambda given: held.append(stress_command(given)), cfg)
    if not all(held):
        sys.exit(TOLERANCE_STATUS)


if __name__ == "__main__":
    main()
