"""The READMEs that stand beside the things: every file that they name exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = sorted((ROOT / "src" / "supersampling").glob("*/README.md"))


@pytest.mark.parametrize("readme", README, ids=lambda path: path.parent.name)
def test_every_named_file_exists(readme):
    names = re.findall(r"`([\w./-]+\.(?:py|yaml|md|json|typ))`", readme.read_text())
    assert len(names) > 3
    folders = [ROOT, readme.parent, readme.parent / "video", ROOT / "src" / "supersampling"]
    missing = [name for name in names if not any((folder / name).exists() for folder in folders)]
    assert not missing


def test_models_stages_metrics_scenes_and_reporting_have_one():
    assert {path.parent.name for path in README} >= {"models", "stages", "metrics", "scenes", "reporting"}


@pytest.mark.parametrize("readme", README, ids=lambda path: path.parent.name)
def test_it_is_short(readme):
    assert len(readme.read_text().splitlines()) <= 45
