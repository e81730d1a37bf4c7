"""What is searched: a model's switches and their options, and every composition of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from supersampling.config import key_of
from supersampling.errors import UserError


@dataclass(frozen=True)
class Rule:
    """When a switch cannot matter: its ``fact`` is at most ``at_most``; ``because`` says why."""

    fact: str
    at_most: float
    because: str


@dataclass(frozen=True)
class Switch:
    """A part that can be swapped: its options' overrides by name, the fullest first, the plainest last.

    Beside one of the options ``unless`` of other switches it is idle.
    """

    name: str
    options: Mapping[str, tuple[str, ...]]
    rules: tuple[Rule, ...] = ()
    unless: Mapping[str, str] = field(default_factory=dict)

    @property
    def plainest(self) -> str:
        return list(self.options)[-1]


@dataclass(frozen=True)
class Composition:
    """One option of every switch."""

    options: Mapping[str, str]
    overrides: tuple[str, ...]

    @property
    def name(self) -> str:
        return " ".join(f"{switch}={option}" for switch, option in self.options.items()) or "the model"


@dataclass(frozen=True)
class Space:
    """A name, what all compositions share, and the switches."""

    name: str
    recipe: tuple[str, ...]
    switches: tuple[Switch, ...]

    def compositions(self) -> list[Composition]:
        """All of them, the one of the fullest options first; an idle switch keeps its plainest option."""
        made = []
        for names in product(*(switch.options for switch in self.switches)):
            chosen = {switch.name: name for switch, name in zip(self.switches, names)}
            if chosen == self.settle(chosen):
                made.append(self.compose(chosen))
        return made

    def settle(self, options: Mapping[str, str]) -> dict[str, str]:
        """The options with every idle switch at its plainest."""
        settled = dict(options)
        for switch in self.switches:
            if any(settled.get(other) == option for other, option in switch.unless.items()):
                settled[switch.name] = switch.plainest
        return settled

    def compose(self, options: Mapping[str, str]) -> Composition:
        own = [o for switch in self.switches for o in switch.options[options[switch.name]]]
        return Composition(dict(options), tuple(merged([*self.recipe, *own])))

    def parts(self, options: Mapping[str, str]) -> int:
        """How many options these lie above the plainest of each switch, in all."""
        return sum(len(s.options) - 1 - list(s.options).index(options[s.name]) for s in self.switches)

    def fixed(self, overrides: Sequence[str]) -> "Space":
        """Without the switches that ``overrides`` set, which join the recipe."""
        given = {key_of(override) for override in overrides}
        kept = [s for s in self.switches if not any(key_of(o) in given for os in s.options.values() for o in os)]
        return Space(self.name, tuple(merged([*self.recipe, *overrides])), tuple(kept))

    def with_only(self, switch: str, options: Sequence[str]) -> "Space":
        """With only these ``options`` of a switch."""
        left = (
            replace(s, options={o: s.options[o] for o in options}) if s.name == switch else s for s in self.switches
        )
        return replace(self, switches=tuple(left))


def merged(overrides: Sequence[str]) -> list[str]:
    """Overrides of which a later one stands in the place of an earlier one of the same key."""
    return list({key_of(override): override for override in overrides}.values())


def read_space(data: Any) -> Space:
    """The space that a file of ``conf/among`` declares.

    Raises:
        UserError: a key is missing, or an option is no list of overrides.
    """
    try:
        switches = tuple(
            Switch(
                str(name),
                {str(option): tuple(map(str, overrides)) for option, overrides in said["options"].items()},
                tuple(Rule(str(r["fact"]), float(r["at_most"]), str(r["because"])) for r in said.get("pointless", ())),
                {str(other): str(option) for other, option in said.get("unless", {}).items()},
            )
            for name, said in data["switches"].items()
        )
        recipe = tuple(map(str, data["recipe"]))
        name = str(data["name"])
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise UserError(
            f"The space does not read ({type(error).__name__}: {error}): give it name, recipe and switches, as in "
            "conf/among/dlctus.yaml."
        ) from error
    if not switches or not all(switch.options for switch in switches):
        raise UserError(f"The space {name} has a switch without options: give each one at least.")
    return Space(name, recipe, switches)
