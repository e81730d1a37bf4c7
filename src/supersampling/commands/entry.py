"""The start of every command: ``supersampling train ...`` and ``python train.py ...`` both come here."""

import os
import sys
import traceback
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from supersampling.commands import campaign
from supersampling.commands.overrides import check_overrides, explanation, with_additions
from supersampling.commands.resolvers import register
from supersampling.config import VERSION_BASE
from supersampling.errors import UserError, find_time_limit, find_user_error, was_interrupted
from supersampling.process import prepare_process
from supersampling.resources import VARIABLE, resources

USER_ERROR_STATUS = 2
INTERRUPTED_STATUS = 130
TIME_LIMIT_STATUS = 124  # as of timeout(1)
COMMANDS = {
    "train": "Train a method, score it on held-out clips, and log both",
    "evaluate": "Score a trained method, or the frames of another program",
    "report": "Write the PDFs, and the tables beside the papers' own",
    "compare": "Compare two methods over the same clips",
    "pick": "Pick the best method for a time, or the fastest for a quality",
    "render": "Render data sets",
    "show": "Write pictures and a video of a data set",
    "import_capture": "Import a capture of another program",
    "export_capture": "Export a data set as a capture of another program",
    "count": "Print the parameters and operations of a method",
    "benchmark": "Time methods under every installed backend",
    "export": "Export a method to ONNX, checked against PyTorch",
    "stress": "Try models at the extremes against a float64 reference",
    "advise": "Find the cheapest composition that a scene requires",
}
"""A line for each command. Its function is ``supersampling.commands.NAME.NAME``, its configuration
``conf/NAME.yaml``."""

FAILED: list[int] = []
"""The exit statuses of the jobs that failed."""


class ExitStatus(Callback):
    """Ends a multirun with the exit status of the first job that failed."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        if FAILED:
            sys.stderr.write(f"{len(FAILED)} of the jobs failed; the same command repeats only these.\n")
            sys.exit(FAILED[0])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run ``supersampling COMMAND ...``; without a command, print a line per command."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    name = words[0].replace("-", "_") if words else ""
    if name in COMMANDS:
        launch(name, words[1:])
        return
    if words and words[0] not in ("-h", "--help"):
        sys.stderr.write(f"error: Unknown command {words[0]}: use one of {', '.join(COMMANDS)}.\n")
        sys.exit(USER_ERROR_STATUS)
    print(
        "supersampling COMMAND [group=option] [key=value] ...        supersampling COMMAND --help lists the settings\n"
    )
    for command, line in COMMANDS.items():
        print(f"  {command:15} {line}")


def script(path: str) -> None:
    """Run the command of a script at the project's root; its outputs go beside the script."""
    os.environ.setdefault(VARIABLE, str(Path(path).resolve().parent))
    launch(Path(path).stem, sys.argv[1:])


def launch(name: str, arguments: Sequence[str]) -> None:
    """Run a command as Hydra reads its arguments, and exit with its status.

    0 is success, 1 an error of ours with its stack trace, 2 a mistake of the user's in one sentence, 124 a training
    that stopped at ``trainer.max_time``, 130 an interrupt; a command may return a status of its own.
    """
    os.environ.setdefault(VARIABLE, os.getcwd())
    os.environ["HYDRA_FULL_ERROR"] = "1"  # Hydra's exceptions reach us instead of its own report
    register()
    arguments = with_additions(name, arguments)
    sys.argv = [sys.argv[0], *arguments]
    try:
        if name == "train" and (commands := campaign.commands(arguments)):
            sys.exit(campaign.run_sweeps(commands))
        check_overrides(name, arguments)
        application(name)()
    except UserError as error:
        _exit_with(error)
    except (HydraException, OmegaConfBaseException) as error:
        sentence = explanation(name, arguments, error)
        if sentence is None:
            raise
        _exit_with(UserError(sentence))


def _exit_with(error: UserError) -> None:
    sys.stderr.write(f"error: {error}\n")
    sys.exit(USER_ERROR_STATUS)


def application(name: str) -> Callable[[], Any]:
    """Return the Hydra application of a command."""

    def task(cfg: DictConfig) -> None:
        # Imported here so that --help is quick.
        command = getattr(import_module(f"supersampling.commands.{name}"), name)
        run(command, cfg)

    task.__module__ = f"supersampling.commands.{name}"
    decorate = hydra.main(config_path=str(resources() / "conf"), config_name=name, version_base=VERSION_BASE)
    return decorate(task)  # type: ignore[no-any-return]


def run(task: Callable[[DictConfig], object], cfg: DictConfig) -> None:
    """Run ``task(cfg)``; print a `UserError` as one sentence and exit with status 2; Ctrl-C and SIGTERM exit with 130.

    A task may return an exit status of its own. The other jobs of a multirun continue after one that failed: see
    `ExitStatus`.
    """
    prepare_process()
    try:
        status = task(cfg)
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        status = _status_of(error)
    if isinstance(status, int) and status:
        if not _is_multirun():
            sys.exit(status)
        FAILED.append(status)


def _is_multirun() -> bool:
    return HydraConfig.initialized() and HydraConfig.get().mode == RunMode.MULTIRUN


def _status_of(error: BaseException) -> int:
    """Report an exception and return the exit status; ours is raised again outside of a multirun."""
    if was_interrupted(error):
        sys.stderr.write("\nInterrupted: the same command continues from here.\n")
        sys.exit(INTERRUPTED_STATUS)
    user_error = find_user_error(error)
    if user_error is not None:
        sys.stderr.write(f"error: {user_error}\n")
        return USER_ERROR_STATUS
    time_limit = find_time_limit(error)
    if time_limit is not None:
        sys.stderr.write(f"{time_limit}\n")
        return TIME_LIMIT_STATUS
    if not _is_multirun():
        raise error
    traceback.print_exception(error)
    return 1
