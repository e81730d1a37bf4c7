"""The switches that are worth a search on a scene, each with its reason and the evidence for it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from supersampling.advice.facts import Fact
from supersampling.advice.space import ModelComposition, Rule, Space, Switch

BuffersOf = Callable[[ModelComposition], frozenset[str]]


@dataclass(frozen=True, kw_only=True)
class Reason:
    """A switch, whether it is searched, the options that remain, the reason, and how the reason was checked."""

    switch: str
    searched: bool
    options: str
    text: str
    check: str


def prune(space: Space, facts: Mapping[str, Fact]) -> tuple[Space, list[Reason]]:
    """Return the space without the switches that cannot matter on a scene with these ``facts``, and the reasons.

    Only facts that were measured in the files decide: a switch whose fact is unknown or from a manifest is searched.
    """
    reasons = []
    for switch in space.switches:
        rule = next((r for r in switch.rules if _holds(r, facts)), None)
        if rule is not None and len(switch.options) > 1:
            space = space.restrict(switch.name, [switch.plainest])
            reasons.append(_explain_pruned(switch, rule, facts[rule.fact]))
        else:
            reasons.append(_explain_searched(switch, facts))
    return space, reasons


def restrict_to_buffers(space: Space, available: frozenset[str], buffers_of: BuffersOf) -> tuple[Space, list[Reason]]:
    """Return the space without the options that read a buffer which a user's files do not have, and the reasons."""
    plain = {switch.name: switch.plainest for switch in space.switches}
    reasons = []
    for switch in space.switches:
        missing = {
            option: buffers_of(space.compose({**plain, switch.name: option})) - available for option in switch.options
        }
        options = [option for option, names in missing.items() if not names]
        if options and len(options) < len(missing):
            space = space.restrict(switch.name, options)
            names = sorted(frozenset[str]().union(*missing.values()))
            reasons.append(
                Reason(
                    switch=switch.name,
                    searched=len(options) > 1,
                    options=" or ".join(options),
                    text=f"the files do not have {', '.join(names)}",
                    check="in the files",
                )
            )
    return space, reasons


def _holds(rule: Rule, facts: Mapping[str, Fact]) -> bool:
    fact = facts.get(rule.fact)
    return fact is not None and fact.source == "files" and fact.value <= rule.at_most


def _explain_pruned(switch: Switch, rule: Rule, fact: Fact) -> Reason:
    exact = fact.value == 0 or rule.at_most >= 1
    extent = "in every frame" if exact else f"except for {fact.value:.2g}, at most {rule.at_most:g}"
    return Reason(
        switch=switch.name,
        searched=False,
        options=switch.plainest,
        text=f"{rule.because} ({extent})",
        check=f"{rule.fact}={fact.value:.3g} in the files",
    )


def _explain_searched(switch: Switch, facts: Mapping[str, Fact]) -> Reason:
    known = [f"{r.fact}={facts[r.fact].value:.3g}" for r in switch.rules if r.fact in facts]
    unknown = [r.fact for r in switch.rules if r.fact not in facts]
    text = "no known fact of the scene decides it"
    if known:
        text = f"it may matter: {', '.join(known)}"
    elif unknown:
        text = f"the files do not show {', '.join(unknown)}"
    return Reason(
        switch=switch.name,
        searched=len(switch.options) > 1,
        options=" or ".join(switch.options),
        text=text,
        check="by the search",
    )


def reason_rows(reasons: Sequence[Reason]) -> list[dict[str, str]]:
    """Return one row of the table per reason."""
    return [
        {
            "switch": reason.switch,
            "options": reason.options,
            "searched": "yes" if reason.searched else "no",
            "why": reason.text,
            "checked": reason.check,
        }
        for reason in reasons
    ]
