"""The start of every command: ``supersampling train ...`` and ``python train.py ...`` both come here."""

import io
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, redirect_stderr
from importlib import import_module
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig

from supersampling import __version__
from supersampling.commands import campaign, completion
from supersampling.commands.boundary import check_configuration, explain
from supersampling.commands.explanation import explanation, raised_by_libraries
from supersampling.commands.flags import Flags, read_flags
from supersampling.commands.overrides import check_overrides, with_additions, without_null
from supersampling.commands.quoting import quote_text
from supersampling.commands.resolvers import register
from supersampling.config import VERSION_BASE
from supersampling.errors import UserError, chain, find_time_limit, find_user_error, was_interrupted
from supersampling.process import prepare_process, silence_libraries
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
    if words and words[0] in completion.FLAGS:
        complete = any(word.startswith("query=") for word in words)
        command = completion.command_to_complete(COMMANDS) if complete else "train"
        if command is not None:
            launch(command, words)
        return
    if words == ["--version"]:
        print(f"supersampling {__version__}")
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
    try:
        flags = read_flags(name, arguments)
        words = [quote_text(name, without_null(word), "multirun" in flags) for word in flags.words]
        _start(name, flags, flags.arguments(with_additions(name, words)))
    except UserError as error:
        exit_with(error)


def _start(name: str, flags: Flags, arguments: list[str]) -> None:
    """Start a command with checked words.

    Raises:
        UserError: what Hydra cannot read or compose.
    """
    if name == "train" and flags.runs and (commands := campaign.commands(arguments)):
        sys.exit(campaign.run_sweeps(commands))
    if name == "train":
        arguments = campaign.with_scenes(arguments)
    if "shell_completion" not in flags:
        check_overrides(name, arguments)
    sys.argv = [sys.argv[0], *arguments]
    try:
        with _quiet() if {"package", "shell_completion"} & flags.values.keys() else nullcontext():
            application(name)()
    except Exception as error:
        user_error = find_user_error(error)  # of a resolver, which Hydra wraps
        if user_error is not None:
            raise user_error from error
        if _reached_command(error) or not raised_by_libraries(error):
            raise
        if "shell_completion" in flags:
            sys.exit(USER_ERROR_STATUS)  # a word before the completed one is wrong; the prompt stays clean
        raise UserError(explanation(name, arguments, error)) from error
    except SystemExit as end:
        if "package" in flags and end.code:  # Hydra ends so if there is no such package
            part = flags.values["package"]
            raise UserError(f"{part} is not set: see python {name}.py --cfg job for the parts.") from end
        raise


def _quiet() -> AbstractContextManager[object]:
    return redirect_stderr(io.StringIO())


def _reached_command(error: Exception) -> bool:
    """Return whether an error comes from a command, not from Hydra while it reads the command line."""
    traces = (traceback.walk_tb(cause.__traceback__) for cause in chain(error))
    return any(frame.f_code is run.__code__ for trace in traces for frame, _ in trace)


def exit_with(error: UserError) -> None:
    """Print a mistake and exit."""
    sys.stderr.write(f"error: {error}\n")
    sys.exit(USER_ERROR_STATUS)


def application(name: str) -> Callable[[], Any]:
    """Return the Hydra application of a command."""

    def task(cfg: DictConfig) -> None:
        def command(cfg: DictConfig) -> object:
            check_configuration(cfg, name)
            # Imported here so that --help is quick.
            function = getattr(import_module(f"supersampling.commands.{name}"), name)
            silence_libraries()
            return function(cfg)

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
    user_error = find_user_error(error) or explain(error)
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
