"""Shell completion of ``supersampling COMMAND ...``: Hydra's own knows scripts only, which have no command word."""

import os
from collections.abc import Collection

FLAGS = ("-sc", "--shell-completion")
LINE = "COMP_LINE"


def command_to_complete(commands: Collection[str]) -> str | None:
    """Return the command of the line that a shell asks about, and take it out of the line, as Hydra expects.

    Without a command, print those that fit the beginning and return None.
    """
    line = os.environ.get(LINE, "")
    program, _, rest = line.lstrip().partition(" ")
    name, space, words = rest.lstrip().partition(" ")
    if space and name.replace("-", "_") in commands:
        os.environ[LINE] = f"{program} {words}"
        return name.replace("-", "_")
    if not space:
        print(" ".join(command for command in commands if command.startswith(name)))
    return None
