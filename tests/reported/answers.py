"""Commands in a process of their own, and what they answer."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]


class Answer(NamedTuple):
    """What a command returned and printed."""

    status: int
    out: str
    err: str

    @property
    def text(self) -> str:
        return self.out + self.err

    @property
    def last_line(self) -> str:
        return next((line for line in reversed(self.text.splitlines()) if line.strip()), "")


def run_script(name: str, arguments: Sequence[str], timeout: float = 240.0, **environment: str) -> Answer:
    """Run a command in a process of its own, which several devices, locks and limits of the system need."""
    result = subprocess.run(
        [sys.executable, f"{name}.py", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=timeout,
        env={**os.environ, "OMP_NUM_THREADS": "1", **environment},
    )
    return Answer(result.returncode, result.stdout, result.stderr)
