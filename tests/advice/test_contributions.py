"""The contributions of parts, against known sums."""

import numpy as np
import pytest

from supersampling.advice.contributions import estimate_contributions, select_latest
from supersampling.advice.space import Space, Switch

SPACE = Space(
    "synthetic",
    ("model=m",),
    (
        Switch("a", {"full": ("x=1",), "half": ("x=2",), "none": ("x=3",)}),
        Switch("b", {"on": ("y=1",), "off": ("y=2",)}),
    ),
)
DECIBELS = {"a": {"full": 0.7, "half": 0.4, "none": 0.0}, "b": {"on": -0.2, "off": 0.0}}
MILLISECONDS = {"a": {"full": 5.0, "half": 2.0, "none": 0.5}, "b": {"on": 3.0, "off": 1.0}}


def test_additive_contributions_are_recovered() -> None:
    compositions = SPACE.compositions()
    clips = np.array([20.0, 25.0, 31.0, 33.0])
    values = {
        (0, k): clips[None] + sum(DECIBELS[s][o] for s, o in c.options.items()) for k, c in enumerate(compositions)
    }
    costs = [sum(MILLISECONDS[s][o] for s, o in c.options.items()) for c in compositions]
    contributions = {
        (c.switch, c.part): c for c in estimate_contributions(SPACE, compositions, values, costs, ["s"] * 4)
    }
    assert set(contributions) == {("a", "full"), ("a", "half"), ("b", "on")}
    for (switch, part), without in {("a", "full"): "half", ("a", "half"): "none", ("b", "on"): "off"}.items():
        contribution = contributions[switch, part]
        assert contribution.without == without
        assert contribution.db.mean == pytest.approx(DECIBELS[switch][part] - DECIBELS[switch][without])
        assert contribution.db.high - contribution.db.low == pytest.approx(0, abs=1e-9)
        assert contribution.ms == pytest.approx(MILLISECONDS[switch][part] - MILLISECONDS[switch][without])
    assert (contributions["a", "full"].pairs, contributions["b", "on"].pairs) == (2, 3)


def test_part_that_depends_on_others_has_a_wide_interval() -> None:
    compositions = SPACE.compositions()
    clips = np.array([20.0, 25.0, 31.0, 33.0])
    # b brings 1 dB beside a=full and takes 1 dB beside a=ncontribution.
    interaction = {"full": 1.0, "half": 0.0, "none": -1.0}
    values = {
        (0, k): clips[None] + (interaction[c.options["a"]] if c.options["b"] == "on" else 0.0)
        for k, c in enumerate(compositions)
    }
    b = next(c for c in estimate_contributions(SPACE, compositions, values, [1.0] * 6, ["s"] * 4) if c.switch == "b")
    assert b.db.mean == pytest.approx(0.0)
    assert b.db.low < -1
    assert b.db.high > 1


def test_last_round_with_a_pair_counts() -> None:
    compositions = SPACE.compositions()
    clips = np.array([20.0, 25.0])
    values = {(0, k): clips[None] for k in range(len(compositions))}
    on, off = (next(k for k, c in enumerate(compositions) if c.options == {"a": "none", "b": b}) for b in ("on", "off"))
    values |= {(1, on): clips[None] + 2, (1, off): clips[None]}
    contributions = {
        (c.switch, c.part): c
        for c in select_latest(estimate_contributions(SPACE, compositions, values, [1.0] * 6, ["s"] * 2))
    }
    assert (contributions["b", "on"].rung, contributions["b", "on"].db.mean) == (1, 2.0)
    assert contributions["a", "full"].rung == 0
