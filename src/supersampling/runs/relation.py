"""The parameters that relate what an evaluation scored to what the weights were trained with.

A plain name is what was scored; with `TRAINED` before it, what the weights were trained with. A training has the plain
names only: both are the same.
"""

from collections.abc import Collection

TRAINED = "trained."
RUN = "trained.run"
SCENES = "test.scenes"
"""How the scored scenes relate to those of the training: see `relation`."""
SAME, SUBSET, UNSEEN, PARTLY, UNKNOWN = "same", "subset", "unseen", "partly", "unknown"
FILES = "files"
"""The option of ``data`` with files that the user names: only they say what scenes they hold."""


def relation(scored: Collection[str], trained: Collection[str]) -> str:
    """Return ``same``: exactly the scenes of the training; ``subset``: some of them; ``unseen``: none of them.

    ``partly`` are some of them and others; ``unknown`` if either is empty.
    """
    if not scored or not trained:
        return UNKNOWN
    if set(scored) == set(trained):
        return SAME
    common = set(scored) & set(trained)
    return SUBSET if common == set(scored) else PARTLY if common else UNSEEN


def in_order(scenes: str) -> str:
    """Return names of scenes, separated by commas, in alphabetical order: a training on ``b,a`` is one on ``a,b``."""
    return ",".join(sorted(scenes.split(",")))
