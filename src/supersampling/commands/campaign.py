"""Several sweeps by one command: ``sweeps=nsrr_table9,nsrr_table10``, or a paper's name for all of its own.

Hydra can sweep over anything but sweeps: it would train the default once for each name, without a word. So each sweep is a
process of its own, one after another; a job that several of them have is done by the first and found again by the others.
"""

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from supersampling.commands.entry import USER_ERROR_STATUS
from supersampling.errors import UserError

KEY = "sweeps="
INTERRUPTED = 130


def commands(arguments: Sequence[str], folder: Path) -> list[list[str]]:
    """The arguments of each sweep's command; of a single sweep, or of none, the arguments as they are.

    Raises:
        UserError: a name that is neither a file of ``folder`` nor the beginning (``<paper>_``) of some; several without ``-m``.
    """
    given = [word for word in arguments if word.startswith(KEY)]
    if len(given) != 1 or given[0] in (KEY, f"{KEY}null"):
        return [list(arguments)]
    known = sorted(path.stem for path in folder.glob("*.yaml"))
    names: list[str] = []
    for name in given[0].removeprefix(KEY).strip("'\"").split(","):
        found = [name] if name in known else [other for other in known if other.startswith(f"{name}_")]
        if not found:
            raise UserError(f"sweeps={name} is no file of {folder.name}/: use a paper or one of {', '.join(known)}.")
        names += [other for other in found if other not in names]
    if not {"-m", "--multirun"} & set(arguments):
        raise UserError(f"{given[0]} runs several jobs: add -m.")
    return [[f"{KEY}{name}" if word == given[0] else word for word in arguments] for name in names]


def run_each(main: Callable[[], None], folder: Path) -> None:
    """Run ``main`` or, of several sweeps, each as a process; the exit status is that of the first that failed.

    The others go on after one that failed, and none after an interrupt.
    """
    try:
        each = commands(sys.argv[1:], folder)
    except UserError as error:
        sys.stderr.write(f"error: {error}\n")
        sys.exit(USER_ERROR_STATUS)
    if len(each) == 1:
        sys.argv[1:] = each[0]
        main()
        return
    failed = 0
    for number, arguments in enumerate(each, 1):
        name = next(word for word in arguments if word.startswith(KEY))
        print(f"{name} ({number} of {len(each)})", flush=True)
        try:
            status = subprocess.run([sys.executable, sys.argv[0], *arguments]).returncode
        except KeyboardInterrupt:  # the terminal sent it to the sweep as well
            status = INTERRUPTED
        if status in (INTERRUPTED, -2, -15):
            sys.exit(INTERRUPTED)
        failed = failed or status
    sys.exit(failed)
