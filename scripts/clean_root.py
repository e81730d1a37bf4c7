"""Run the README's commands in a new minimal Debian without git and without a compiler, as a stranger would.

Needs root and mmdebstrap. Makes the root in a temporary folder (below $TMPDIR), copies the tracked files into it as
they stand in the working tree, runs each command by chroot, prints its last lines and minutes, and removes the root.
Mounts live in a namespace of their own, so removing the root cannot reach this machine's files.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
PACKAGES = "python3,python3-venv,make,ca-certificates"
ABSENT = ("git", "c++", "g++", "cc", "gcc", "clang", "sudo", "ffmpeg", "fc-list")
COMMANDS = ("make demo STK=0", "make test")
QUICK = (
    "make setup",
    ".venv/bin/python train.py -m model=dlctus loss.theta=0.1,0.5 budget=smoke data=smoke",
    ".venv/bin/python report.py",
    "make test",
)
# How the root reaches the network and the package index, where this machine has these.
FILES = ("/etc/resolv.conf", "/etc/hosts", "/etc/pip.conf", "/etc/xdg/pip", "~/.config/pip", "~/.pip")
VARIABLES = re.compile(r"PIP_\w+|(http|https|ftp|all|no)_proxy", re.IGNORECASE)
SEARCH_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
HOME = "/root"
FOLDER = f"{HOME}/supersampling"


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commands", nargs="*", help=f"shell commands to run instead of: {'; '.join(COMMANDS)}")
    parser.add_argument("--quick", action="store_true", help="a sweep on the smallest data in place of the demo")
    parser.add_argument("--suite", default="bookworm", help="Debian release (default: bookworm, with Python 3.11)")
    parser.add_argument("--mirror", action="append", default=[], help="mirror or sources file for mmdebstrap")
    parser.add_argument("--aptopt", action="append", default=[], help="line or file of apt options for mmdebstrap")
    parser.add_argument("--bind", action="append", default=[], metavar="PATH", help="show PATH in the root, read-only")
    parser.add_argument("--env", action="append", default=[], metavar="NAME", help="pass the variable NAME on")
    parser.add_argument("--keep", action="store_true", help="leave the root where it is, for a look around")
    parser.add_argument("--lines", type=int, default=15, help="last lines to print of each command (default: 15)")
    parser.add_argument(
        "--logs", type=Path, default=REPOSITORY / ".cache" / "clean_root", help="folder of whole outputs"
    )
    options = parser.parse_args(arguments)
    options.commands = options.commands or list(QUICK if options.quick else COMMANDS)
    return options


def tracked_files(repository: Path) -> list[str]:
    """Return the tracked files that exist in the working tree, relative to ``repository``."""
    listing = subprocess.run(["git", "ls-files", "-z"], cwd=repository, check=True, capture_output=True, text=True)
    return [name for name in listing.stdout.split("\0") if name and (repository / name).is_file()]


def copy_files(names: Iterable[str], source: Path, target: Path) -> None:
    for name in names:
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source / name, target / name)


def passed_environment(names: Iterable[str]) -> dict[str, str]:
    """Return the root's whole environment: its own PATH and HOME, pip's and proxy variables, and ``names``."""
    passed = {name: value for name, value in os.environ.items() if VARIABLES.fullmatch(name) or name in names}
    return {"PATH": SEARCH_PATH, "HOME": HOME, **passed}


def bound_paths(paths: Iterable[str]) -> dict[Path, str]:
    """Return the existing default paths and ``paths`` (which must exist), each with its place in the root."""
    for path in paths:
        if not Path(path).exists():
            sys.exit(f"--bind {path}: there is no such path.")
    existing = [path for path in FILES if Path(path).expanduser().exists()]
    return {
        Path(path).expanduser().resolve(): path.replace("~", HOME, 1) if path.startswith("~") else os.path.abspath(path)
        for path in [*existing, *paths]
    }


def prepare_mount_points(root: Path, binds: dict[Path, str]) -> None:
    for source, place in binds.items():
        point = root / place.lstrip("/")
        if point.is_symlink():
            point.unlink()
        if source.is_dir():
            point.mkdir(parents=True, exist_ok=True)
        else:
            point.parent.mkdir(parents=True, exist_ok=True)
            point.touch()


def chroot_command(root: Path, binds: dict[Path, str], environment: dict[str, str], command: str) -> list[str]:
    """Return the words that run ``command`` in ``root`` in namespaces of its own: no mount or process outlives it."""
    script = [
        'root=$1; command=$2; shift 2; mount -t proc proc "$root/proc"; mount -o bind,ro /sys "$root/sys"',
        # Python's locks between processes and PyTorch's loaders need shared memory.
        'mount -t tmpfs tmpfs "$root/dev/shm"',
        'while [ "$1" != -- ]; do mount -o bind,ro "$1" "$root$2"; shift 2; done; shift',
        f'exec chroot "$root" env -i "$@" sh -c "cd {FOLDER} 2>/dev/null; $command"',
    ]
    namespaces = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "--propagation", "private"]
    mounts = [word for source, place in binds.items() for word in (str(source), place)]
    variables = [f"{name}={value}" for name, value in environment.items()]
    return [*namespaces, "sh", "-ec", "\n".join(script), "sh", str(root), command, *mounts, "--", *variables]


@contextmanager
def clean_root(options: argparse.Namespace) -> Iterator[Path]:
    """Make a minimal Debian in a temporary folder, and remove it in the end."""
    folder = Path(tempfile.mkdtemp(prefix="clean-root-"))
    try:
        root = folder / "root"
        aptopt = [f"--aptopt={option}" for option in options.aptopt]
        words = ["mmdebstrap", "--variant=minbase", f"--include={PACKAGES}", *aptopt, options.suite, str(root)]
        created = subprocess.run([*words, *options.mirror], capture_output=True, text=True)
        if created.returncode:
            sys.exit(f"{created.stderr[-2000:]}\nmmdebstrap failed: give it a reachable --mirror.")
        yield root
    finally:
        if options.keep:
            print(f"The root stays in {folder}.")
        else:
            shutil.rmtree(folder)


def run(command: list[str], log: Path) -> tuple[int, float, list[str]]:
    """Run ``command`` with its output in ``log``; return its status, minutes and lines."""
    start = time.monotonic()
    with log.open("wb") as file:
        status = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT).returncode
    # A progress bar returns to the start of its line: only its last state counts.
    lines = [line.rstrip("\r").rsplit("\r", 1)[-1] for line in log.read_bytes().decode(errors="replace").split("\n")]
    return status, (time.monotonic() - start) / 60, [line for line in lines if line.strip()]


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if os.geteuid() != 0:
        sys.exit("A chroot needs root: run this script with sudo.")
    for program, package in (("mmdebstrap", "mmdebstrap"), ("git", "git"), ("unshare", "util-linux")):
        if shutil.which(program) is None:
            sys.exit(f"{program} is missing: apt-get install {package}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    binds, environment = bound_paths(options.bind), passed_environment(options.env)
    options.logs.mkdir(parents=True, exist_ok=True)
    for log in options.logs.glob("*.log"):
        log.unlink()
    start = time.monotonic()
    with clean_root(options) as root:
        copy_files(tracked_files(REPOSITORY), REPOSITORY, root / FOLDER.lstrip("/"))
        prepare_mount_points(root, binds)
        present = [name for name in ABSENT if shutil.which(name, path=chroot_path(root))]
        if present:
            sys.exit(f"The root is not clean: it has {', '.join(present)}.")
        print(f"{options.suite} with {PACKAGES}: {(time.monotonic() - start) / 60:.1f} min", flush=True)
        failed = 0
        for k, command in enumerate(options.commands):
            print(f"\n$ {command}", flush=True)
            log = options.logs / f"{k}.log"
            status, minutes, lines = run(chroot_command(root, binds, environment, command), log)
            print(*lines[-options.lines :], sep="\n")
            print(
                f"-> {'passed' if status == 0 else f'FAILED with status {status}'}, {minutes:.1f} min ({log})",
                flush=True,
            )
            failed += status != 0
        return 1 if failed else 0


def chroot_path(root: Path) -> str:
    """Return the root's search path as seen from outside."""
    return ":".join(str(root / folder.lstrip("/")) for folder in SEARCH_PATH.split(":"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
