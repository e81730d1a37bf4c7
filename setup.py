"""Copies the folders that commands read at run time into the wheel; everything else stands in pyproject.toml."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

RESOURCES = ("conf", "sweeps", "reports")
OUTPUTS = "out"  # of report.py


class BuildWithResources(build_py):
    """Builds the package with ``supersampling/resources``; a development install reads the checkout instead."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        for folder in RESOURCES:
            target = Path(self.build_lib) / "supersampling" / "resources" / folder
            ignore = shutil.ignore_patterns(OUTPUTS)
            shutil.copytree(Path(__file__).parent / folder, target, ignore=ignore, dirs_exist_ok=True)


setup(cmdclass={"build_py": BuildWithResources})
