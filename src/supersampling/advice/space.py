"""The space of a search: a model's switches with their options, and every composition of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from supersampling.config import key_of
from supersampling.errors import UserError


@dataclass(frozen=True)
class Rule:
    """A condition under which a switch cannot matter: ``fact`` is at most ``at_most``; ``because`` gives the reason."""

    fact: str
    at_most: float
    because: str


@dataclass(frozen=True)
class Switch:
    """A part that can be exchanged.

    ``options`` are the overrides of each option by name, from the fullest to the plainest. A switch is idle if another
    switch has its option of ``unless``.
    """

    name: str
    options: Mapping[str, tuple[str, ...]]
    rules: tuple[Rule, ...] = ()
    unless: Mapping[str, str] = field(default_factory=dict)

    @property
    def fullest(self) -> str:
        """The name of the first option."""
        return next(iter(self.options))

    @property
    def plainest(self) -> str:
        """The name of the last option."""
        return list(self.options)[-1]


@dataclass(frozen=True)
class ModelComposition:
    """One option per switch, and the overrides that select them."""

    options: Mapping[str, str]
    overrides: tuple[str, ...]

    @property
    def name(self) -> str:
        """The options as text."""
        return " ".join(f"{switch}={option}" for switch, option in self.options.items()) or "the model"


@dataclass(frozen=True)
class Space:
    """A name, the overrides that all compositions share, and the switches."""

    name: str
    recipe: tuple[str, ...]
    switches: tuple[Switch, ...]

    def compositions(self) -> list[ModelComposition]:
        """Return all compositions, the fullest first; an idle switch has its plainest option only."""
        compositions = []
        for names in product(*(switch.options for switch in self.switches)):
            options = {switch.name: name for switch, name in zip(self.switches, names)}
            if options == self.settle(options):
                compositions.append(self.compose(options))
        return compositions

    def settle(self, options: Mapping[str, str]) -> dict[str, str]:
        """Return the options with every idle switch at its plainest option."""
        settled = dict(options)
        for switch in self.switches:
            if any(settled.get(name) == option for name, option in switch.unless.items()):
                settled[switch.name] = switch.plainest
        return settled

    def compose(self, options: Mapping[str, str]) -> ModelComposition:
        """Return the composition of one option per switch."""
        overrides = [override for switch in self.switches for override in switch.options[options[switch.name]]]
        return ModelComposition(dict(options), tuple(merge_overrides([*self.recipe, *overrides])))

    def count_parts(self, options: Mapping[str, str]) -> int:
        """Return how many steps the options are above the plainest option of their switches, in total."""
        return sum(len(s.options) - 1 - list(s.options).index(options[s.name]) for s in self.switches)

    def fix(self, overrides: Sequence[str]) -> "Space":
        """Return the space without the switches that ``overrides`` set; the overrides join the recipe."""
        keys = {key_of(override) for override in overrides}
        switches = [s for s in self.switches if not any(key_of(o) in keys for os in s.options.values() for o in os)]
        return Space(self.name, tuple(merge_overrides([*self.recipe, *overrides])), tuple(switches))

    def restrict(self, switch: str, options: Sequence[str]) -> "Space":
        """Return the space with these ``options`` of a switch only."""
        switches = (
            replace(s, options={o: s.options[o] for o in options}) if s.name == switch else s for s in self.switches
        )
        return replace(self, switches=tuple(switches))


def merge_overrides(overrides: Sequence[str]) -> list[str]:
    """Return the overrides, of which a later one takes the place of an earlier one with the same key."""
    return list({key_of(override): override for override in overrides}.values())


def read_space(data: Any) -> Space:
    """Return the space that a file of ``conf/among`` declares.

    Raises:
        UserError: a key is missing, or an option is not a list of overrides.
    """
    try:
        switches = tuple(_read_switch(str(name), switch) for name, switch in data["switches"].items())
        recipe = tuple(map(str, data["recipe"]))
        name = str(data["name"])
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise UserError(
            f"The space cannot be read ({type(error).__name__}: {error}): give it a name, a recipe and switches, as in "
            "conf/among/dlctus.yaml."
        ) from error
    if not switches or not all(switch.options for switch in switches):
        raise UserError(
            f"The space {name} has no switches, or a switch without options: give each at least one option."
        )
    return Space(name, recipe, switches)


def _read_switch(name: str, data: Mapping[str, Any]) -> Switch:
    return Switch(
        name,
        {str(option): tuple(map(str, overrides)) for option, overrides in data["options"].items()},
        tuple(Rule(str(r["fact"]), float(r["at_most"]), str(r["because"])) for r in data.get("pointless", ())),
        {str(switch): str(option) for switch, option in data.get("unless", {}).items()},
    )
