"""Which switches are worth a search on a scene, each with its reason and how it was checked."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from supersampling.advice.facts import Fact
from supersampling.advice.space import Composition, Rule, Space, Switch

Reads = Callable[[Composition], frozenset[str]]


@dataclass(frozen=True)
class Reason:
    """A switch, whether it is searched or left at its plainest option, and why."""

    switch: str
    tried: bool
    kept: str
    why: str
    checked: str


def prune(space: Space, facts: Mapping[str, Fact]) -> tuple[Space, list[Reason]]:
    """The space without what cannot matter on a scene of these ``facts``.

    A rule holds by what the files' own buffers say: a fact that is unknown, or a manifest's, leaves a switch to the search.
    """
    reasons = []
    for switch in space.switches:
        rule = next((r for r in switch.rules if _holds(r, facts)), None)
        if rule is not None and len(switch.options) > 1:
            space = space.with_only(switch.name, [switch.plainest])
            reasons.append(_left_out(switch, rule, facts[rule.fact]))
        else:
            reasons.append(_tried(switch, facts))
    return space, reasons


def within(space: Space, held: frozenset[str], reads: Reads) -> tuple[Space, list[Reason]]:
    """The space without the options that read a buffer which a user's files do not hold."""
    plain = {switch.name: switch.plainest for switch in space.switches}
    reasons = []
    for switch in space.switches:
        lacking = {o: sorted(reads(space.compose({**plain, switch.name: o})) - held) for o in switch.options}
        kept = [o for o, names in lacking.items() if not names]
        if kept and len(kept) < len(lacking):
            space = space.with_only(switch.name, kept)
            names = sorted({n for lacks in lacking.values() for n in lacks})
            why = f"the files do not hold {', '.join(names)}"
            reasons.append(Reason(switch.name, len(kept) > 1, " or ".join(kept), why, "in the files"))
    return space, reasons


def _holds(rule: Rule, facts: Mapping[str, Fact]) -> bool:
    fact = facts.get(rule.fact)
    return fact is not None and fact.source == "files" and fact.value <= rule.at_most


def _left_out(switch: Switch, rule: Rule, fact: Fact) -> Reason:
    exact = (
        "in every frame"
        if fact.value == 0 or rule.at_most >= 1
        else f"but for {fact.value:.2g}, up to {rule.at_most:g}"
    )
    return Reason(
        switch.name,
        False,
        switch.plainest,
        f"{rule.because} ({exact})",
        f"{rule.fact}={fact.value:.3g} in the files",
    )


def _tried(switch: Switch, facts: Mapping[str, Fact]) -> Reason:
    known = [f"{r.fact}={facts[r.fact].value:.3g}" for r in switch.rules if r.fact in facts]
    unknown = [r.fact for r in switch.rules if r.fact not in facts]
    why = "nothing known of the scene decides it"
    if known:
        why = f"it may matter: {', '.join(known)}"
    elif unknown:
        why = f"the files do not tell {', '.join(unknown)}"
    return Reason(switch.name, len(switch.options) > 1, " or ".join(switch.options), why, "by the search")


def rows(reasons: Sequence[Reason]) -> list[dict[str, str]]:
    """As a table."""
    return [
        {
            "switch": r.switch,
            "options": r.kept,
            "searched": "yes" if r.tried else "no",
            "why": r.why,
            "checked": r.checked,
        }
        for r in reasons
    ]
