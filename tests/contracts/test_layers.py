"""Imports point down only: a room never imports one above it (docs/structure.md)."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "supersampling"
LEVEL = {
    "errors": 0, "entry": 0, "resolvers": 4, "pretrained": 0, "ops": 0, "frames": 1, "losses": 2, "metrics": 2,
    "stages": 2, "data": 2,
    "models": 3, "render": 3, "show": 3, "training": 4, "profiling": 4, "reporting": 4, "deploy": 4, "evaluation": 4,
    "advice": 4, "stress": 4,
}  # fmt: skip
FILES = sorted(PACKAGE.rglob("*.py"))


def room(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_down(path):
    own = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if own == "__init__":
        return
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for name in names:
            target = room(name) if name.startswith("supersampling.") else ""
            if target and target != own:
                assert LEVEL[target] <= LEVEL[own], f"{path.name} imports {name}, which is above it"


def test_every_room_has_a_level():
    rooms = {p.relative_to(PACKAGE).parts[0].removesuffix(".py") for p in FILES} - {"__init__"}
    assert rooms <= set(LEVEL)
