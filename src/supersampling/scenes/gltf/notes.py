"""What of a file is drawn otherwise than it says: counted while it is read, and told once, as warnings."""

import warnings
from collections import Counter


class Notes:
    """`add` as often as something occurs, `tell` once."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._counts: Counter[str] = Counter()

    def add(self, what: str) -> None:
        self._counts[what] += 1

    def tell(self) -> None:
        """One `UserWarning` a kind."""
        for what, count in self._counts.items():
            times = "" if count == 1 else f" ({count} times)"
            warnings.warn(f"{self._name}: {what}{times}.", UserWarning, stacklevel=3)
