"""Wording rules for the source: words that make unclear names, openings of docstrings, and line length.

``structure_numbers.py`` counts violations; ``tests/contracts/test_words.py`` allows none in ``src``. The functions take
the nodes of a syntax tree, ``list(ast.walk(tree))``, or the text of a file.
"""

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

# These words say what happened to a value, or point at it, but not what it is.
PARTICIPLES = {"found", "made", "said", "held", "told", "given", "wanted", "kept", "chosen", "taken", "asked", "needed"}
PRONOUNS = {"ours", "theirs", "mine", "own", "one", "other", "others", "each", "every", "both"}
WORDS = PARTICIPLES | PRONOUNS | {"tell", "had", "why", "lacking", "lacks", "refused", "anew", "let_go"}
# Terms of the field that begin or end with such a word.
TERMS = {"one_hot", "one_sided", "validate_every"}
_UNCLEAR = re.compile(rf"({'|'.join(sorted(WORDS))})(_.*)?|.*_({'|'.join(sorted(WORDS))})")
OPENINGS = ("What", "Which", "How", "Where")
MARGIN = 120

Function = ast.FunctionDef | ast.AsyncFunctionDef
Documented = ast.Module | ast.ClassDef | Function


@dataclass(frozen=True)
class Finding:
    """One violation: ``text`` at ``line`` of a file."""

    line: int
    text: str


def is_unclear(name: str) -> bool:
    """Return True if a name is one of `WORDS`, or if its first or last part between underscores is one."""
    plain = name.strip("_").lower()
    return plain not in TERMS and _UNCLEAR.fullmatch(plain) is not None


def definitions(nodes: Sequence[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line and name of each definition: functions, classes, parameters, variables, attributes and aliases.

    Skip the parameter ``other`` of operators such as ``__eq__``: Python's own documentation calls it that.
    """
    operands = {
        id(argument)
        for node in nodes
        if isinstance(node, Function) and node.name.startswith("__") and node.name.endswith("__")
        for argument in node.args.args
        if argument.arg == "other"
    }
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield node.lineno, name
            case ast.arg(arg=name) if id(node) not in operands:
                yield node.lineno, name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield node.lineno, name
            case ast.alias(asname=str(name)):
                yield node.lineno, name
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield node.lineno, name
            case ast.MatchMapping(rest=str(name)):
                yield node.lineno, name


def occurrences(nodes: Sequence[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line and name of every definition, and of every place where a variable, attribute or keyword is used."""
    yield from definitions(nodes)
    for node in nodes:
        if isinstance(node, ast.Name | ast.Attribute) and not isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id if isinstance(node, ast.Name) else node.attr
        elif isinstance(node, ast.keyword) and node.arg:
            yield node.lineno, node.arg


def unclear_names(nodes: Sequence[ast.AST]) -> list[Finding]:
    """Return the definitions whose names are unclear, except test functions (``test_*``), whose names are sentences."""
    return [
        Finding(line, name) for line, name in definitions(nodes) if is_unclear(name) and not name.startswith("test_")
    ]


def indirect_docstrings(nodes: Sequence[ast.AST]) -> list[Finding]:
    """Return the docstrings that open with a question word instead of a verb or a noun."""
    findings = []
    for node in nodes:
        if isinstance(node, Documented):
            words = (ast.get_docstring(node) or "").split()
            if words and words[0].rstrip(",:'s") in OPENINGS:
                findings.append(Finding(getattr(node, "lineno", 1), " ".join(words[:8])))
    return findings


def long_lines(text: str) -> list[Finding]:
    """Return the lines of more than `MARGIN` characters."""
    return [Finding(k, line[:60]) for k, line in enumerate(text.splitlines(), 1) if len(line) > MARGIN]
