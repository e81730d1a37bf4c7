"""Imports point down only: a room imports the rooms below it and no others (docs/structure.md)."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "supersampling"
ROOMS = (  # from the bottom up
    "errors",
    "files",
    "process",
    "settings",
    "resources",
    "config",
    "ops",
    "frames",
    "pretrained",
    "metrics",
    "losses",
    "stages",
    "models",
    "data",
    "scenes",
    "render",
    "show",
    "evaluation",
    "deploy",
    "runs",
    "profiling",
    "training",
    "advice",
    "stress",
    "reporting",
    "commands",
    "api",
)
LEVEL = {room: level for level, room in enumerate(ROOMS)}
FILES = sorted(PACKAGE.rglob("*.py"))


def modules_of(tree: ast.AST, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the full name of each module that a file imports: absolute, relative, or by a string."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            prefix = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{prefix}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            yield node.value


def room_of(module: str) -> str | None:
    """Return the room of a module, None outside of the package."""
    names = module.split(".")
    return names[1] if names[0] == "supersampling" and len(names) > 1 and names[1] in LEVEL else None


def rises(source: str, path: Path) -> list[str]:
    """Return the modules that a file imports from rooms that are not below its own."""
    room = path.parts[0].removesuffix(".py")
    package = ("supersampling", *path.parts[:-1])
    targets = [(name, room_of(name)) for name in modules_of(ast.parse(source), package)]
    return [name for name, target in targets if target not in (None, room) and LEVEL[target] > LEVEL[room]]


@pytest.mark.parametrize("path", [p for p in FILES if p.parent != PACKAGE or p.stem in LEVEL], ids=str)
def test_imports_point_down(path):
    assert not rises(path.read_text(), path.relative_to(PACKAGE))


def test_every_room_has_a_level():
    rooms = {p.relative_to(PACKAGE).parts[0].removesuffix(".py") for p in FILES} - {"__init__", "__main__"}
    assert rooms == set(ROOMS)


@pytest.mark.parametrize(
    "source",
    [
        "from supersampling.commands import entry",
        "import supersampling.training.job",
        "from ..runs import store",
        "from .. import runs",
        "importlib.import_module('supersampling.deploy.quantise')",
    ],
)
def test_a_rise_is_seen(source):
    assert rises(source, Path("ops/warp.py"))


def test_a_scene_imports_the_kit_and_the_scene_types_only():
    """What one built-in scene changes can then change no data set of another."""
    scenes = PACKAGE / "scenes"
    shared = {"kit", "scene", "errors"}
    for folder in sorted(p for p in scenes.iterdir() if (p / f"{p.name}.py").exists()):
        for path in sorted(folder.glob("*.py")):
            for name in modules_of(ast.parse(path.read_text()), ("supersampling", "scenes", folder.name)):
                parts = name.split(".")
                if parts[0] == "supersampling":
                    room = parts[2] if parts[1] == "scenes" else parts[1]
                    assert room in shared | {folder.name}, f"{path.name} imports {name}"
