"""Install Debian packages that are missing if this user may; else print the command to run, and fail."""

import os
import shutil
import subprocess
import sys

INSTALL = ("install", "--yes", "--no-install-recommends")
# Another process, such as an automatic upgrade, may hold the lock; nobody is there to answer a question.
OPTIONS = ("-o", "DPkg::Lock::Timeout=300")
QUIET = {"DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C"}


def installed(package: str) -> bool:
    """Return True if dpkg has ``package`` unpacked and configured."""
    query = ["dpkg-query", "-W", "-f", "${Status}", package]
    return "install ok installed" in subprocess.run(query, capture_output=True, text=True).stdout


def apt_get(*arguments: str) -> str | None:
    """Run apt-get as root without a question; return the end of its output if it fails, else None."""
    result = subprocess.run(
        ["apt-get", *OPTIONS, *arguments],
        env={**os.environ, **QUIET},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    return None if result.returncode == 0 else "\n".join(result.stdout.strip().splitlines()[-5:])


def main(packages: list[str]) -> int:
    if shutil.which("dpkg-query") is None or shutil.which("apt-get") is None:
        print(f"This is not Debian or Ubuntu: install what it calls {' '.join(packages)} yourself.")
        return 0
    missing = [package for package in packages if not installed(package)]
    if not missing:
        return 0
    command = " ".join(["apt-get", *INSTALL, *missing])
    if os.geteuid() != 0:
        root = "sudo " if shutil.which("sudo") else ""
        print(f"Missing: {' '.join(missing)}. Run as root: {root}apt-get update && {root}{command}")
        return 1
    print(command, flush=True)
    # A failed update is not an error yet: the lists that are there may be enough.
    messages = [apt_get("update"), apt_get(*INSTALL, *missing)]
    if messages[-1] is not None:
        print("\n".join(message for message in messages if message))
        print(f"That failed. Run it by hand: apt-get update && {command}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
