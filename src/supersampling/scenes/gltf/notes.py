"""Deviations of the drawn scene from its file: counted while reading, then reported as warnings."""

import warnings
from collections import Counter

from supersampling.scenes.gltf.features import Deviation, ignored_extension


class Notes:
    """Counters of deviations: call `add` for each occurrence and `warn` once at the end."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._counts: Counter[str] = Counter()

    def add(self, deviation: Deviation) -> None:
        self._counts[deviation.value] += 1

    def add_extension(self, name: str) -> None:
        """Count an extension that is ignored."""
        self._counts[ignored_extension(name)] += 1

    def warn(self) -> None:
        """Issue one `UserWarning` per kind."""
        for what, count in self._counts.items():
            times = "" if count == 1 else f" ({count} times)"
            warnings.warn(f"{self._name}: {what}{times}.", UserWarning, stacklevel=3)
