"""Names of configured classes: ``model/reproject=bicubic9`` in place of a dotted path.

Identities, checkpoints and exports hold these names, so that moving or renaming a class invalidates none of them. The
names are those of the files in ``conf/``: a class that one file names is called as that file; several files of one
class differ in numbers, so it is called by the beginning that their names share (``enss_s``, ``enss_m``: ``enss``).
"""

import os
from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from supersampling.config import read_option
from supersampling.errors import UserError
from supersampling.resources import resources

TARGET, OPTION = "_target_", "option"
FORMER: dict[str, str] = {}
"""Former class paths, as the first scheme's runs and checkpoints hold them, to today's. A class that moves adds a
line."""


class Options:
    """The options of a ``conf`` folder by class path, and back."""

    def __init__(self, folder: Path) -> None:
        files: dict[tuple[str, str], list[str]] = defaultdict(list)  # group and class path to file names
        for path in sorted(folder.rglob("*.yaml")):
            group = path.parent.relative_to(folder).as_posix()
            target = _target_of(path)
            if group != "." and target is not None:
                files[group, target].append(path.stem)
        self._names = {target: f"{group}={_shared_name(group, stems)}" for (group, target), stems in files.items()}
        self._targets = {name: target for target, name in self._names.items()}

    def name(self, target: str) -> str:
        """Return the option that names a class; of a class outside of ``conf/``, its name without the path."""
        return self._names.get(target, target.rpartition(".")[2])

    def target(self, name: str) -> str | None:
        """Return the class path of an option, None if ``conf/`` has no such option."""
        return self._targets.get(name)

    def __iter__(self) -> Iterable[tuple[str, str]]:  # type: ignore[override]
        return iter(self._names.items())


def _target_of(path: Path) -> str | None:
    """Return the class that a file names, or else that of the last file in its group that it is based on."""
    content, bases = read_option(path)
    if TARGET in content:
        return str(content[TARGET])
    targets = [target for base in bases if (target := _target_of(base))]
    return targets[-1] if targets else None


def _shared_name(group: str, stems: list[str]) -> str:
    """Return the beginning that the names share, or the group's name if they share none."""
    return os.path.commonprefix(stems).rstrip("_") or group.rpartition("/")[2]


@lru_cache
def options() -> Options:
    """Return the options of this project's ``conf/``."""
    return Options(resources() / "conf")


def described(config: Any) -> Any:
    """Return a resolved configuration with each class path replaced by the option that names it."""
    if isinstance(config, Mapping):
        content = {str(k): described(v) for k, v in config.items() if k != TARGET}
        if TARGET in config:
            path = str(config[TARGET])
            content[OPTION] = options().name(FORMER.get(path, path))
        return content
    return [described(value) for value in config] if isinstance(config, (list, tuple)) else config


def restored(config: Any, source: str) -> Any:
    """Return a model's configuration as `described` read it, for Hydra to instantiate: only options of ``conf/model``.

    Args:
        source: where the configuration was read, for messages.

    Raises:
        UserError: an option or a class that ``conf/model`` does not have, or an interpolation.
    """
    if isinstance(config, Mapping):
        content = {str(k): restored(v, source) for k, v in config.items() if k not in (TARGET, OPTION)}
        if TARGET in config or OPTION in config:
            content[TARGET] = _class_path(config, source)
        return content
    if isinstance(config, (list, tuple)):
        return [restored(value, source) for value in config]
    if isinstance(config, str) and "${" in config:
        raise UserError(f"{source} contains the interpolation {config}, so it was not loaded: use plain values only.")
    return config


def _class_path(config: Mapping[Any, Any], source: str) -> str:
    """Return the class of a model or stage; nothing else is built from a file."""
    if OPTION in config:
        name = option = str(config[OPTION])
    else:  # written by the first scheme
        name = str(config[TARGET])
        option = options().name(FORMER.get(name, name))
    path = options().target(option)
    if path is None or not option.startswith(("model=", "model/")):
        raise UserError(
            f"{source} names {name}, which is neither a model nor a stage of conf/model, so it was not loaded: use the "
            "version that wrote it or, if you trust the file, set model=... as it was trained."
        )
    return path
