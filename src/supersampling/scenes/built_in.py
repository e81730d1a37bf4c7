"""Scenes built by the project itself; the manifest beside each describes what it shows."""

from collections.abc import Callable

from supersampling.scenes.airstrip import airstrip
from supersampling.scenes.arena import arena
from supersampling.scenes.atrium import atrium
from supersampling.scenes.bar import bar
from supersampling.scenes.foundry import foundry
from supersampling.scenes.louvres import louvres
from supersampling.scenes.market import market
from supersampling.scenes.scene import Scene
from supersampling.scenes.sundial import sundial
from supersampling.scenes.turntable import turntable

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
