"""Compilation of this folder's C++, once per machine, and the loaded library."""

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
from supersampling.files import replace_file

FOLDER = Path(__file__).parent
SOURCES = sorted(FOLDER.glob("*.cpp"))
# Only contraction to fused multiply-adds is allowed, so that NaN stays NaN.
FLAGS = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
LINK_FLAGS = ("-fopenmp", "-shared", "-fPIC", "-std=c++17")


@functools.cache
def load_library() -> ctypes.CDLL:
    """Load the compiled passes; compile into the user's cache folder if source, compiler or machine are new.

    Raises:
        UserError: there is no compiler, or it cannot compile the source.
    """
    compiler = shutil.which(os.environ.get("CXX", "c++"))
    if compiler is None:
        raise UserError(
            f"C++ compiler {os.environ.get('CXX', 'c++')} not found: install g++ 12 or later, set CXX, or use a "
            "backend that needs no compiler, such as eager or openvino."
        )
    path = _cache_folder() / f"{_fingerprint(compiler)}.so"
    if not path.is_file():
        _compile(compiler, path)
    try:
        return ctypes.CDLL(str(path))
    except OSError:  # a crash left a part of it
        _compile(compiler, path)
        return ctypes.CDLL(str(path))


def _cache_folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "supersampling"


def _fingerprint(compiler: str) -> str:
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False).stdout
    sources = [path.read_text() for path in (*SOURCES, *sorted(FOLDER.glob("*.h")))]
    parts = (*sources, *FLAGS, *LINK_FLAGS, version, platform.node(), platform.machine())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def _compile(compiler: str, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        out = Path(folder) / path.name
        command = [compiler, *FLAGS, *LINK_FLAGS, *map(str, SOURCES), "-o", str(out)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            first = next((line for line in done.stderr.splitlines() if "error" in line), "no error message")
            raise UserError(
                f"{compiler} cannot compile {FOLDER.name}/*.cpp ({first.strip()}): set CXX to g++ 12 or later, or use "
                "another backend."
            )
        replace_file(out, path)
