"""Scenes made by the project itself."""

from collections.abc import Callable

from ..scene import Scene
from .atrium import atrium
from .foundry import foundry

BUILT_IN: dict[str, Callable[[], Scene]] = {
    "atrium": atrium,
    "foundry": foundry,
}
