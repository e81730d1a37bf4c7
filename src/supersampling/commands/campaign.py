"""Several sweeps by one command: ``sweeps=nsrr_table9,nsrr_table10``, or a paper's name for all of its own; and a job
for each scene: ``scene=each``.

Hydra can sweep over anything but sweeps: it would train the default once per name, without a word. So each sweep is a
process of its own, one after another; a job that several of them have is done by the first, and the others find it
finished.
"""

import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import OmegaConf

from supersampling.config import composed, key_of
from supersampling.errors import UserError
from supersampling.resources import resources

KEY = "sweeps="
PER_SCENE = "scene=each"
INTERRUPTED = 130


def commands(arguments: Sequence[str], folder: Path | None = None) -> list[list[str]]:
    """Return the arguments of each sweep's command; an empty list if there is one sweep or none.

    Args:
        folder: of the sweeps' files.

    Raises:
        UserError: a name that is neither a file of ``folder`` nor the beginning (``<paper>_``) of some; several without
            ``-m``.
    """
    sweeps = [word for word in arguments if word.startswith(KEY)]
    if len(sweeps) > 1:
        joined = ",".join(word.removeprefix(KEY) for word in sweeps)
        raise UserError(f"{' '.join(sweeps)} sets sweeps twice: write {KEY}{joined}.")
    if not sweeps or sweeps[0] in (KEY, f"{KEY}null"):
        return []
    known = sorted(path.stem for path in (folder or resources() / "sweeps").glob("*.yaml"))
    names: list[str] = []
    for name in sweeps[0].removeprefix(KEY).strip("'\"").split(","):
        matches = [name] if name in known else [stem for stem in known if stem.startswith(f"{name}_")]
        if not matches:
            raise UserError(f"There is no sweep {name} in sweeps/: use a paper or one of {', '.join(known)}.")
        names += [match for match in matches if match not in names]
    if not {"-m", "--multirun"} & set(arguments):
        raise UserError(f"{sweeps[0]} runs several jobs: add -m.")
    if names == [sweeps[0].removeprefix(KEY)]:
        return []
    return [[f"{KEY}{name}" if word == sweeps[0] else word for word in arguments] for name in names]


def run_sweeps(sweeps: Sequence[Sequence[str]]) -> int:
    """Run each sweep as a process and return the exit status of the first that failed.

    The others continue after a failure; none is started after an interrupt.
    """
    failed = 0
    for number, arguments in enumerate(sweeps, 1):
        name = next(word for word in arguments if word.startswith(KEY))
        print(f"{name} ({number} of {len(sweeps)})", flush=True)
        try:
            status = subprocess.run([sys.executable, "-m", "supersampling", "train", *arguments]).returncode
        except KeyboardInterrupt:  # the terminal sent it to the sweep as well
            status = INTERRUPTED
        if status in (INTERRUPTED, -2, -15):
            return INTERRUPTED
        failed = failed or status
    return failed


def with_scenes(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with ``scene=each`` replaced by a sweep over the scenes that the others select together.

    Raises:
        UserError: without ``-m``; several experiments that select different scenes.
    """
    if PER_SCENE not in arguments:
        return list(arguments)
    if not {"-m", "--multirun"} & set(arguments):
        raise UserError(f"{PER_SCENE} trains a network per scene, so it runs several jobs: add -m.")
    scenes = _scenes_of([word for word in arguments if "=" in word and not word.startswith("-") and word != PER_SCENE])
    return [f"scene={','.join(scenes)}" if word == PER_SCENE else word for word in arguments]


def _scenes_of(words: Sequence[str]) -> list[str]:
    """Return the scenes of every job that the words sweep over."""
    selecting = [word for word in words if key_of(word) in ("experiment", "data", "sweeps")]
    params = {} if (name := _sweep_of(selecting)) is None else _parameters(name)
    if "scene" in params:  # the sweep itself has a job for each scene
        return str(params["scene"]).split(",")
    swept = [f"{key}={value}" for key, value in params.items() if key in ("experiment", "data")]
    jobs, *_ = BasicSweeper.split_arguments(OverridesParser.create().parse_overrides([*swept, *selecting]), None)
    selected = [composed("train", job).cfg.scene for job in jobs]
    lists = {(scene,) if isinstance(scene, str) else tuple(scene) for scene in selected}
    if len(lists) > 1:
        choices = " and ".join("[" + ",".join(scenes) + "]" for scenes in sorted(lists))
        raise UserError(f"{PER_SCENE} with jobs that select different scenes, {choices}: name the scenes, scene=a,b.")
    return [str(scene) for scene in lists.pop()]


def _sweep_of(words: Sequence[str]) -> str | None:
    names = [word.removeprefix(KEY) for word in words if word.startswith(KEY)]
    return names[0] if names and names[0] else None


def _parameters(sweep: str) -> Mapping[str, Any]:
    """Return what a sweep's file sweeps over."""
    content: Any = OmegaConf.load(resources() / "sweeps" / f"{sweep}.yaml")
    return dict(content.hydra.sweeper.params)
