"""Install Debian packages that are missing where that is allowed; else print the one line to run, and fail."""

import os
import shutil
import subprocess
import sys


def installed(package: str) -> bool:
    query = ["dpkg-query", "-W", "-f", "${Status}", package]
    return "install ok installed" in subprocess.run(query, capture_output=True, text=True).stdout


def main(packages: list[str]) -> int:
    if shutil.which("dpkg-query") is None:
        print(f"This is not Debian or Ubuntu: install what it calls {' '.join(packages)} (OpenGL without a screen).")
        return 0
    missing = [package for package in packages if not installed(package)]
    if not missing:
        return 0
    line = f"apt-get install --yes --no-install-recommends {' '.join(missing)}"
    if os.geteuid() != 0:
        print(f"Missing: {' '.join(missing)}. Run: sudo {line}")
        return 1
    print(line, flush=True)
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    quiet = {"env": environment, "stdout": subprocess.DEVNULL}
    subprocess.run(["apt-get", "update"], **quiet)
    if subprocess.run(line.split(), **quiet).returncode != 0:
        print(f"That failed. Run it by hand: {line}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
