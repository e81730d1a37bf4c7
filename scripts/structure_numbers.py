"""Print what the structure of a checkout measures: ``python scripts/structure_numbers.py [CHECKOUT] [--places]``.

All numbers come from the syntax trees of the checkout's files. Nothing is imported from the checkout, so any commit can
be measured, and this file and ``wording.py`` need only Python. ``--places`` also lists the places behind each number.
"""

import argparse
import ast
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from wording import Documented, Finding, indirect_docstrings, is_unclear, long_lines, occurrences, unclear_names

PACKAGE = "supersampling"
TAG = re.compile(r"(?<![\w.])ss\.[a-z]")
# Options of conf/model that are also words of image processing (mode="bicubic"): only their classes count.
GENERAL_WORDS = frozenset({"bicubic", "nearest"})
# Files where a model's name means something else: the capture format NSRD, and citations in the table of buffers.
NOT_ABOUT_MODELS = ("data/", "frames.py")
# A literal with at least this many strings, of which this share begins with a top-level key of conf/, lists keys.
LIST_LENGTH, LIST_SHARE = 6, 0.8


@dataclass(frozen=True)
class File:
    """A Python file: its path in the checkout, its text, and its syntax tree."""

    name: str
    text: str

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text)

    @cached_property
    def nodes(self) -> list[ast.AST]:
        return list(ast.walk(self.tree))

    @cached_property
    def names(self) -> list[tuple[int, str]]:
        return list(occurrences(self.nodes))

    @property
    def lines(self) -> int:
        return len(self.text.splitlines())

    @cached_property
    def strings(self) -> list[ast.Constant]:
        """Every string that is not a docstring, parts of f-strings included."""
        documented = [node for node in self.nodes if isinstance(node, Documented)]
        firsts = [node.body[0] for node in documented if node.body]
        docstrings = {id(first.value) for first in firsts if isinstance(first, ast.Expr)}
        constants = [node for node in self.nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)]
        return [node for node in constants if id(node) not in docstrings]


def read(root: Path, folder: str) -> list[File]:
    """Return the Python files below a folder of the checkout."""
    paths = sorted((root / folder).rglob("*.py"))
    return [File(path.relative_to(root / folder).as_posix(), path.read_text()) for path in paths]


def imports(file: File, modules: frozenset[str]) -> Iterator[tuple[int, str]]:
    """Yield line and dotted name of each import: absolute, relative, or a module of the package in a string."""
    package = [PACKAGE, *Path(file.name).parent.parts]
    for node in file.nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*start, *([node.module] if node.module else [])])
            for alias in node.names:
                yield node.lineno, f"{module}.{alias.name}"
    for string in file.strings:
        if string.value in modules:
            yield string.lineno, string.value


def room_of(file: File) -> str:
    """Return the room of a file: the folder, or the file itself where it lies at the top of the package."""
    return Path(file.name).parts[0].removesuffix(".py")


def mutual_imports(files: list[File]) -> list[str]:
    """Return the pairs of rooms that import each other, with the number of imports each way."""
    rooms = {room_of(file) for file in files} - {"__init__"}
    paths = [Path(file.name).with_suffix("").parts for file in files]
    modules = frozenset(".".join((PACKAGE, *parts)).removesuffix(".__init__") for parts in paths) - {PACKAGE}
    arrows: Counter[tuple[str, str]] = Counter()
    for file in files:
        for _, name in imports(file, modules):
            parts = name.split(".")
            if parts[0] == PACKAGE and len(parts) > 1 and parts[1] in rooms - {room_of(file)}:
                arrows[room_of(file), parts[1]] += 1
    pairs = sorted((a, b) for a, b in arrows if a < b and (b, a) in arrows)
    return [f"{a} ({arrows[a, b]}) <-> {b} ({arrows[b, a]})" for a, b in pairs]


def tag_files(files: list[File]) -> list[str]:
    """Return the files that spell a tag of the MLflow store, such as ``ss.kind``."""
    return [file.name for file in files if any(TAG.search(string.value) for string in file.strings)]


def key_lists(root: Path, files: list[File]) -> list[str]:
    """Return the module-level tuples, lists, sets and tables that enumerate configuration keys."""
    keys = {path.name for path in (root / "conf").iterdir() if path.is_dir()}
    for path in (root / "conf").glob("*.yaml"):
        keys |= set(re.findall(r"^(\w+):", path.read_text(), re.MULTILINE))
    lists = []
    for file in files:
        for node in file.tree.body:
            if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.AST):
                target = node.targets[0] if isinstance(node, ast.Assign) else node.target
                words = _row(node.value)
                known = [word for word in words if re.split(r"[./=]", word)[0] in keys | {"hydra"}]
                if len(words) >= LIST_LENGTH and len(known) >= LIST_SHARE * len(words):
                    lists.append(f"{file.name}:{node.lineno} {ast.unparse(target)}")
    return lists


def _row(value: ast.AST) -> list[str]:
    """Return the strings of a literal tuple, list or set, or a dictionary's keys if most of them have no dot."""
    if isinstance(value, ast.Call) and value.args:  # frozenset((...)), tuple([...])
        return _row(value.args[0])
    items = value.elts if isinstance(value, ast.Tuple | ast.List | ast.Set) else getattr(value, "keys", [])
    strings = [item.value for item in items if isinstance(item, ast.Constant) and isinstance(item.value, str)]
    dotted = sum("." in text for text in strings)
    return [] if isinstance(value, ast.Dict) and 2 * dotted > len(strings) else strings


def model_names(root: Path) -> frozenset[str]:
    """Return the options of the group ``model``, their classes, and the classes' names in small letters."""
    paths = list((root / "conf" / "model").glob("*.yaml"))
    targets = [re.search(r"^_target_: .*?(\w+)$", path.read_text(), re.MULTILINE) for path in paths]
    classes = {match[1] for match in targets if match}
    return frozenset({path.stem for path in paths} | classes | {name.lower() for name in classes})


def model_mentions(root: Path, files: list[File]) -> list[str]:
    """Return the lines outside of ``models/`` that name a model, by an identifier or in a string."""
    names = model_names(root)
    pattern = re.compile(rf"(?<!\w)({'|'.join(sorted(names - GENERAL_WORDS, key=len, reverse=True))})(?!\w)")
    places: dict[str, set[int]] = defaultdict(set)
    for file in files:
        if file.name.startswith(("models/", *NOT_ABOUT_MODELS)):
            continue
        lines = places[file.name]
        lines |= {string.lineno for string in file.strings if pattern.search(string.value)}
        lines |= {line for line, name in file.names if name in names - GENERAL_WORDS}
        lines |= {line for line, name in imports(file, frozenset()) if name.split(".")[-1] in names - GENERAL_WORDS}
    return [f"{name}:{line}" for name, lines in places.items() for line in sorted(lines)]


def repeated_classes(files: list[File]) -> list[str]:
    """Return the public names that stand for two or more classes, with how many."""
    nodes = [node for file in files for node in file.nodes if isinstance(node, ast.ClassDef)]
    counts = Counter(node.name for node in nodes if not node.name.startswith("_"))
    return [f"{name} x{count}" for name, count in sorted(counts.items()) if count > 1]


def asserted_types(file: File) -> list[Finding]:
    """Return every ``assert`` that something ``is not None``."""
    tests = [node.test for node in file.nodes if isinstance(node, ast.Assert)]
    return [Finding(test.lineno, ast.unparse(test)) for test in tests if "is not None" in ast.unparse(test)]


def skipped_formats(file: File) -> list[Finding]:
    lines = enumerate(file.text.splitlines(), 1)
    return [Finding(k, line.strip()) for k, line in lines if line.rstrip().endswith("# fmt: skip")]


def collect(files: list[File], check: Callable[[File], list[Finding]]) -> list[str]:
    """Return the findings of a check in all files as ``file:line text``."""
    return [f"{file.name}:{finding.line} {finding.text}" for file in files for finding in check(file)]


def modules_named(files: list[File]) -> list[str]:
    """Return the files whose own name is unclear."""
    return [file.name for file in files if is_unclear(Path(file.name).stem)]


def used(files: list[File]) -> int:
    """Return how often an unclear name is written, as a definition or in use; ``hypothesis.given`` does not count."""
    total = 0
    for file in files:
        nodes = [node for node in file.nodes if isinstance(node, ast.ImportFrom) and node.module == "hypothesis"]
        foreign = {alias.name for node in nodes for alias in node.names}
        names = [name for _, name in file.names if name not in foreign and not name.startswith("test_")]
        total += sum(map(is_unclear, names))
    return total


def measure(root: Path) -> list[tuple[str, int, list[str]]]:
    """Return each measurement: what it is, its number, and the places behind it."""
    src, tests = read(root, f"src/{PACKAGE}"), read(root, "tests")
    rest = [file for folder in ("scripts", "benchmarks") for file in read(root, folder)]
    rest += [File(path.name, path.read_text()) for path in sorted(root.glob("*.py"))]
    unclear, unclear_tests = (collect(files, lambda f: unclear_names(f.nodes)) for files in (src, tests))
    lists = {
        "pairs of rooms that import each other": mutual_imports(src),
        "files with a literal ss. tag": tag_files(src),
        "lists of configuration keys": key_lists(root, src),
        "places outside models/ and conf/ that name a model": model_mentions(root, src),
        "public class names used twice or more": repeated_classes(src),
        "# fmt: skip in src": collect(src, skipped_formats),
        "# fmt: skip in tests, scripts, benchmarks": collect([*tests, *rest], skipped_formats),
        "unclear words as identifiers in src, definitions": unclear,
        "unclear words as identifiers in tests, definitions": unclear_tests,
        "files of src with an unclear name": modules_named(src),
        "assert ... is not None in src": collect(src, asserted_types),
        "docstrings of src opening with What/Which/How/Where": collect(src, lambda f: indirect_docstrings(f.nodes)),
        "docstrings of tests opening with What/Which/How/Where": collect(tests, lambda f: indirect_docstrings(f.nodes)),
        "lines longer than 120 in src": collect(src, lambda f: long_lines(f.text)),
        "lines longer than 120 in tests, scripts, benchmarks": collect([*tests, *rest], lambda f: long_lines(f.text)),
    }
    counts = {
        "unclear words as identifiers in src, definitions and uses": used(src),
        "unclear words as identifiers in tests, definitions and uses": used(tests),
        "lines of src": sum(file.lines for file in src),
        "files of src": len(src),
        "lines of tests": sum(file.lines for file in tests),
        "lines of scripts, benchmarks and entry points": sum(file.lines for file in rest),
    }
    return [(name, len(places), places) for name, places in lists.items()] + [(k, n, []) for k, n in counts.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checkout", type=Path, nargs="?", default=Path(__file__).resolve().parents[1])
    parser.add_argument("--places", action="store_true", help="list where each number comes from")
    arguments = parser.parse_args()
    for name, number, places in measure(arguments.checkout):
        print(f"{number:6}  {name}")
        if arguments.places:
            print("".join(f"            {place}\n" for place in places), end="")


if __name__ == "__main__":
    main()
