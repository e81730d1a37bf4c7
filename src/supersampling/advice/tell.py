"""What ``advise.py`` prints."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from supersampling.advice.answer import Found
from supersampling.advice.contributions import latest
from supersampling.advice.facts import Fact
from supersampling.advice.prior import Reason
from supersampling.runs.statistics import Estimate


def _say(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def _table(rows: Sequence[Mapping[str, object]]) -> str:
    return pd.DataFrame(list(rows)).to_string(index=False) if rows else "(nothing)"


def facts(scenes: Sequence[str], found: Mapping[str, Fact]) -> None:
    _say(f"What {', '.join(scenes)} has:")
    _say(
        _table(
            [{"fact": k, "value": f"{f.value:.3g}", "from": f.source, "what it is": f.about} for k, f in found.items()]
        )
    )


def reasons(found: Sequence[Reason]) -> None:
    _say("", "What is worth a search:")
    for reason in found:
        words = f"search {reason.kept}" if reason.tried else f"{reason.kept}, not searched"
        _say(f"  {reason.switch}: {words}; {reason.why} ({reason.checked}).")
    _say("")


def interval(estimate: Estimate) -> str:
    if estimate.clips == 0:
        return "not searched"
    return f"{estimate.mean:+.3f} ({estimate.low:+.3f} to {estimate.high:+.3f})"


def found(result: Found) -> None:
    """The rounds, what each part brought, the buffers, and the answer."""
    rounds = result.search_table()
    rounds["loss (95%)"] = [interval(step.loss) for step in result.search.steps]
    columns = ["round", "steps", "seeds", "composition", "ms", "psnr", "loss (95%)", "verdict"]
    _say(
        "",
        "The search; loss is against the round's best, dB:",
        rounds[columns].round(3).to_string(index=False),
    )
    parts = [
        {
            "part": f"{c.switch}={c.part}",
            "against": c.without,
            "dB (95%)": interval(c.db),
            "ms": f"{c.ms:+.1f}",
            "round": c.rung + 1 if c.pairs else "-",
            "pairs": c.pairs,
            "in the answer": "yes" if result.chosen.options.get(c.switch) == c.part else "no",
        }
        for c in latest(result.parts)
    ]
    _say("", "What each part brings here:", _table(parts))
    _buffers(result)
    _answer(result)


def _buffers(result: Found) -> None:
    rows = [row for row in result.buffers if not row["needed"]]
    if not rows:
        _say("", "The answer reads every buffer that the space knows.")
        return
    _say("", "Buffers that the renderer may leave out:")
    _say(
        _table(
            [
                {
                    "buffer": row["buffer"],
                    "kB a frame": f"{row['bytes'] / 1e3:.1f}",
                    "ms to render alone": "not measured" if row["render_ms"] is None else f"{row['render_ms']:.1f}",
                }
                for row in rows
            ]
        )
    )


def _answer(result: Found) -> None:
    said = result.summary()
    loss = result.answer.losses[result.answer.chosen]
    _say(
        "",
        f"Answer: {said['chosen']}",
        f"  {said['ms']:.1f} ms a frame of {said['size']} rendered pixels; the best, {said['best']}, takes "
        f"{said['best_ms']:.1f}.",
        f"  It loses {interval(loss)} dB against the best, within margin={result.margin:g} by the interval's end.",
    )
    if result.answer.chosen == result.answer.best and len(result.answer.losses) > 1:
        _say("  No cheaper one is proven to be within the margin, so the best itself is named.")
    if result.search.last + 1 < len(result.trainings.rungs.epochs):
        _say("  The steps allowed no further round: this is of shorter trainings than were asked for.")
    for candidate in result.answer.open:
        _say(
            f"  Not resolved: {result.compositions[candidate].name} costs less "
            f"({result.costs[candidate].ms:.1f} ms) and loses {interval(result.answer.losses[candidate])} dB: more seeds, or "
            "more test clips, would tell."
        )
    _say(
        f"  The search took {said['trainings']} trainings, {said['steps']:,} steps, {said['minutes']:.1f} minutes of training; "
        f"to walk all {said['compositions']} compositions, {said['walk_trainings']} trainings, {said['walk_steps']:,} steps, "
        f"about {said['walk_minutes']:.0f} minutes."
    )


def after(path: Path, name: str, out: Path, run_id: str) -> None:
    shown = os.path.relpath(out) if out.resolve().is_relative_to(Path.cwd()) else str(out)
    _say(f"Written to {path} and to run {run_id}. To train it, and score it by every metric:")
    _say(f"  python train.py --config-dir {shown} experiment={name}")
