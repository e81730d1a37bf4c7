"""Compiles this folder's C++ once for a machine, and loads it."""

import ctypes
import functools
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

from supersampling.errors import UserError

FOLDER = Path(__file__).parent
SOURCES = sorted(FOLDER.glob("*.cpp"))
# Sums may be reassociated into fused multiply-adds, nothing else: a NaN stays one.
FLAGS = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
LINKED = ("-fopenmp", "-shared", "-fPIC", "-std=c++17")


@functools.cache
def library() -> ctypes.CDLL:
    """The passes, compiled when source, compiler or machine are new, and kept in the user's cache folder.

    Raises:
        UserError: there is no compiler, or it does not take the source.
    """
    compiler = shutil.which(os.environ.get("CXX", "c++"))
    if compiler is None:
        raise UserError(
            f"There is no C++ compiler {os.environ.get('CXX', 'c++')}: install g++ 12 or later, set CXX, or use a backend that "
            "needs none, such as eager or openvino."
        )
    built = _folder() / f"{_name(compiler)}.so"
    if not built.is_file():
        _compile(compiler, built)
    return ctypes.CDLL(str(built))


def _folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "supersampling"


def _name(compiler: str) -> str:
    said = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False).stdout
    text = [path.read_text() for path in (*SOURCES, *sorted(FOLDER.glob("*.h")))]
    known = (*text, *FLAGS, *LINKED, said, platform.node(), platform.machine())
    return hashlib.sha256("\0".join(known).encode()).hexdigest()[:16]


def _compile(compiler: str, built: Path) -> None:
    built.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=built.parent) as folder:
        out = Path(folder) / built.name
        command = [compiler, *FLAGS, *LINKED, *map(str, SOURCES), "-o", str(out)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            first = next((line for line in done.stderr.splitlines() if "error" in line), "it says nothing")
            raise UserError(
                f"{compiler} cannot compile {FOLDER.name}/*.cpp ({first.strip()}): set CXX to g++ 12 or later, or use another "
                "backend."
            )
        os.replace(out, built)
