"""Text on a command line: paths and names are read as they are typed, whatever characters they contain.

Hydra's grammar knows lists, numbers, sweeps and interpolations, and rejects many characters of file names. The settings
of this module hold text, so their values need none of that grammar.
"""

import os
import re
import shlex
from collections.abc import Iterator

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import ChoiceSweep, Override, Quote, QuotedString
from hydra.errors import HydraException

from supersampling.config import key_of

PATHS = {
    *("path", "checkpoint", "capture", "file", "out", "output", "published", "templates"),
    *("paths.root", "paths.data", "paths.artifacts", "paths.checkpoints", "hydra.run.dir", "hydra.sweep.dir"),
}
"""Settings that hold one path."""

TEXTS = {"run", "name", "a", "b", "dataset", "paper", "tracking_uri", "experiment_name"}
"""Settings that hold other text, such as the id 3e7, which is no number."""

PATH_LISTS = {"data.train", "data.val", "data.test"}
WORD_LISTS = {"models", "methods", "extremes", "precisions", "splits"}

_PART = re.compile(r"""'(?:\\.|[^'\\])*'|"(?:\\.|[^"\\])*"|\\.|.""", re.DOTALL)
_PARSER = OverridesParser.create()


def quote(text: str, interpolate: bool = False) -> str:
    """Return the value that Hydra reads as exactly this text.

    Args:
        interpolate: whether ``${key}`` keeps its meaning.
    """
    if not interpolate:
        text = re.sub(r"(\\*)\$\{", lambda match: match[1] * 2 + r"\${", text)
    return QuotedString(text, Quote.double).with_quotes()


def shell_word(key: str, text: str) -> str:
    """Return the word to type in a shell to set a key to this text."""
    return shlex.quote(f"{key}={quote(text)}")


def parse(value: str) -> Override | None:
    """Return what Hydra reads as a value, None if its grammar rejects it."""
    try:
        return _PARSER.parse_override(f"key={value}")
    except HydraException:
        return None


def is_key(key: str) -> bool:
    """Return whether Hydra reads a word as a key, with its prefix and package."""
    try:
        _PARSER.parse_override(f"{key}=1")
    except HydraException:
        return False
    return True


def quote_text(command: str, word: str, multirun: bool) -> str:
    """Return an override with its text in quotes where Hydra would reject it or read something else.

    Args:
        word: such as ``checkpoint=out/epoch=9.ckpt``, which Hydra rejects, or ``run=3e7``, which it reads as a number.
        multirun: whether commas separate the values of a sweep.
    """
    key, sign, value = word.partition("=")
    setting = key_of(word)
    if not sign or word.startswith("~"):
        return word
    if setting in PATH_LISTS | WORD_LISTS:
        return f"{key}={_list(value, setting in PATH_LISTS, multirun)}"
    is_path = setting in PATHS or (command, setting) == ("evaluate", "frames")
    if is_path or setting in TEXTS:
        return f"{key}={_text(value, is_path, multirun)}"
    if os.path.exists(value) and parse(value) is None:
        return f"{key}={quote(value)}"
    return word


def _text(value: str, is_path: bool, multirun: bool) -> str:
    """Return a value in quotes unless Hydra reads it as text, null or a sweep."""
    override = parse(value)
    items = split(value)
    if multirun and len(items) > 1 and (override is None or _is_choice(override)):
        return ",".join(_text(item, is_path, False) for item in items)
    if is_path and os.path.exists(value) and _is_misread(override, value):
        return quote(value)
    if override is None:
        return quote(os.path.expanduser(value) if is_path else value, interpolate=True)
    if override.is_sweep_override():
        return value
    content = override.value()
    if is_path and isinstance(content, str) and content.startswith("~") and not os.path.exists(content):
        return quote(os.path.expanduser(content), interpolate=True)
    return value if content is None or isinstance(content, str) else quote(value)


def _is_misread(override: Override | None, value: str) -> bool:
    """Return whether Hydra reads the name of an existing file as something else, and not as another file."""
    if override is None or override.is_sweep_override() or "${" in value:
        return True
    content = override.value()
    return content is not None and content != value and not (isinstance(content, str) and os.path.exists(content))


def _is_choice(override: Override) -> bool:
    """Return whether a value is a sweep of the form ``a,b``."""
    sweep = override._value
    return isinstance(sweep, ChoiceSweep) and sweep.simple_form


def _list(value: str, is_path: bool, multirun: bool) -> str:
    """Return a list with its text in quotes where that is needed; one value becomes a list of its own."""
    items = split(value)
    if len(items) > 1 and multirun:
        return ",".join(_list(item, is_path, False) for item in items)
    if len(items) == 1 and value.startswith("[") and value.endswith("]"):
        items = split(value[1:-1]) if value[1:-1].strip() else []
    elif not _is_plain(value) or any(item.startswith("[") for item in items):
        return value
    items = [item.strip() for item in items]
    texts = [quote(item) if item.endswith("\\") else _text(item, is_path, False) for item in items]
    return f"[{','.join(texts)}]"


def _is_plain(value: str) -> bool:
    """Return whether a value is text or several texts, and no null, dictionary, function or interpolation."""
    if not value or value.startswith(("${", "{")):
        return False
    override = parse(value)
    if override is None or _is_choice(override):
        return True
    return not override.is_sweep_override() and override.value() is not None


def split(value: str) -> list[str]:
    """Return the parts of a value between its commas outside of quotes and brackets."""
    parts, depth = [""], 0
    for token in _tokens(value):
        depth += (token in "[({") - (token in "])}")
        if token == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += token
    return parts


def _tokens(value: str) -> Iterator[str]:
    return (match[0] for match in _PART.finditer(value))
