"""The printed output of ``advise.py``."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from supersampling.advice.answer import SearchResult
from supersampling.advice.contributions import select_latest
from supersampling.advice.facts import Fact
from supersampling.advice.prior import Reason
from supersampling.runs.statistics import Estimate


def _print_lines(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def _table(rows: Sequence[Mapping[str, object]]) -> str:
    return pd.DataFrame(list(rows)).to_string(index=False) if rows else "(nothing)"


def print_facts(scenes: Sequence[str], facts: Mapping[str, Fact]) -> None:
    """Print the facts of the scenes."""
    rows = [
        {"fact": name, "value": f"{fact.value:.3g}", "from": fact.source, "meaning": fact.about}
        for name, fact in facts.items()
    ]
    _print_lines(f"Facts of {', '.join(scenes)}:", _table(rows))


def print_reasons(reasons: Sequence[Reason]) -> None:
    """Print for each switch whether it is searched, and the reason."""
    _print_lines("", "Switches that are worth a search:")
    for reason in reasons:
        plan = f"search {reason.options}" if reason.searched else f"{reason.options}, not searched"
        _print_lines(f"  {reason.switch}: {plan}; {reason.text} ({reason.check}).")
    _print_lines("")


def format_interval(estimate: Estimate) -> str:
    """Return a mean with its interval."""
    if estimate.clips == 0:
        return "not searched"
    return f"{estimate.mean:+.3f} ({estimate.low:+.3f} to {estimate.high:+.3f})"


def print_result(result: SearchResult) -> None:
    """Print the rounds, the contribution of each part, the buffers, and the answer."""
    rounds = result.search_table()
    rounds["loss (95%)"] = [format_interval(row.loss) for row in result.halving.results]
    columns = ["round", "steps", "seeds", "composition", "ms", "psnr", "loss (95%)", "verdict"]
    table = rounds[columns].round(3).to_string(index=False)
    _print_lines("", "The search; the loss is against the best of the round, in dB:", table)
    parts = [
        {
            "part": f"{c.switch}={c.part}",
            "against": c.without,
            "dB (95%)": format_interval(c.db),
            "ms": f"{c.ms:+.1f}",
            "round": c.rung + 1 if c.pairs else "-",
            "pairs": c.pairs,
            "in the answer": "yes" if result.includes(c) else "no",
        }
        for c in select_latest(result.contributions)
    ]
    _print_lines("", "The contribution of each part:", _table(parts))
    _print_buffers(result)
    _print_answer(result)


def _print_buffers(result: SearchResult) -> None:
    rows = [
        {
            "buffer": row["buffer"],
            "kB per frame": f"{row['bytes'] / 1e3:.1f}",
            "ms to render separately": "not measured" if row["render_ms"] is None else f"{row['render_ms']:.1f}",
        }
        for row in result.unneeded_buffers
    ]
    if rows:
        _print_lines("", "Buffers that the renderer may leave out:", _table(rows))
    else:
        _print_lines("", "The answer reads every buffer that the space reads.")


def _print_answer(result: SearchResult) -> None:
    summary, decision = result.summary(), result.decision
    _print_lines(
        "",
        f"Answer: {summary['chosen']}",
        f"  {summary['ms']:.1f} ms per frame of {summary['size']} rendered pixels; the best, {summary['best']}, takes "
        f"{summary['best_ms']:.1f} ms.",
        f"  It loses {format_interval(decision.losses[decision.selected])} dB against the best; the interval ends "
        f"within margin={result.margin:g}.",
    )
    if decision.selected == decision.best and len(decision.losses) > 1:
        _print_lines("  No cheaper composition is proven to be within the margin, so the best itself is the answer.")
    if result.halving.last_rung < result.trainings.rungs.last:
        _print_lines("  The steps did not allow another round: the answer is of shorter trainings than requested.")
    for candidate in decision.unresolved:
        _print_lines(
            f"  Not resolved: {result.compositions[candidate].name} costs less ({result.costs[candidate].ms:.1f} ms) "
            f"and loses {format_interval(decision.losses[candidate])} dB: add seeds or test clips to decide."
        )
    _print_lines(
        f"  The search took {summary['trainings']} trainings, {summary['steps']:,} steps and {summary['minutes']:.1f} "
        f"minutes of training; all {summary['compositions']} compositions would take {summary['walk_trainings']} "
        f"trainings, {summary['walk_steps']:,} steps and about {summary['walk_minutes']:.0f} minutes."
    )


def print_commands(path: Path, name: str, out: Path, run_id: str) -> None:
    """Print where the answer is, and the command that trains it."""
    folder = os.path.relpath(out) if out.resolve().is_relative_to(Path.cwd()) else str(out)
    _print_lines(
        f"Written to {path} and to run {run_id}. To train the answer and score it by every metric:",
        f"  python train.py --config-dir {folder} experiment={name}",
    )
