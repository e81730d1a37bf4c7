"""Scenes made by the project itself; the manifest beside each says what it shows."""

from collections.abc import Callable

from ..scene import Scene
from .airstrip import airstrip
from .arena import arena
from .atrium import atrium
from .bar import bar
from .foundry import foundry
from .louvres import louvres
from .market import market
from .sundial import sundial
from .turntable import turntable

BUILT_IN: dict[str, Callable[[], Scene]] = {
    "airstrip": airstrip,
    "arena": arena,
    "atrium": atrium,
    "bar": bar,
    "foundry": foundry,
    "louvres": louvres,
    "market": market,
    "sundial": sundial,
    "turntable": turntable,
}
