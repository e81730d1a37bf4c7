"""What parts bring, against sums that are known."""

import numpy as np
import pytest

from supersampling.advice.contributions import contributions, latest
from supersampling.advice.space import Space, Switch

SPACE = Space(
    "made",
    ("model=m",),
    (
        Switch("a", {"full": ("x=1",), "half": ("x=2",), "none": ("x=3",)}),
        Switch("b", {"on": ("y=1",), "off": ("y=2",)}),
    ),
)
BRINGS = {"a": {"full": 0.7, "half": 0.4, "none": 0.0}, "b": {"on": -0.2, "off": 0.0}}
TAKES = {"a": {"full": 5.0, "half": 2.0, "none": 0.5}, "b": {"on": 3.0, "off": 1.0}}


def test_what_adds_up_is_taken_apart() -> None:
    made = SPACE.compositions()
    clips = np.array([20.0, 25.0, 31.0, 33.0])
    values = {(0, k): clips[None] + sum(BRINGS[s][o] for s, o in c.options.items()) for k, c in enumerate(made)}
    costs = [sum(TAKES[s][o] for s, o in c.options.items()) for c in made]
    found = {(c.switch, c.part): c for c in contributions(SPACE, made, values, costs, ["s"] * 4)}
    assert set(found) == {("a", "full"), ("a", "half"), ("b", "on")}
    for (switch, part), without in {("a", "full"): "half", ("a", "half"): "none", ("b", "on"): "off"}.items():
        one = found[switch, part]
        assert one.without == without
        assert one.db.mean == pytest.approx(BRINGS[switch][part] - BRINGS[switch][without])
        assert one.db.high - one.db.low == pytest.approx(0, abs=1e-9)
        assert one.ms == pytest.approx(TAKES[switch][part] - TAKES[switch][without])
    assert (found["a", "full"].pairs, found["b", "on"].pairs) == (2, 3)


def test_a_part_that_depends_on_others_has_a_wide_interval() -> None:
    made = SPACE.compositions()
    clips = np.array([20.0, 25.0, 31.0, 33.0])
    # b brings 1 dB beside a=full and takes 1 dB beside a=none.
    inter = {"full": 1.0, "half": 0.0, "none": -1.0}
    values = {
        (0, k): clips[None] + (inter[c.options["a"]] if c.options["b"] == "on" else 0.0) for k, c in enumerate(made)
    }
    b = next(c for c in contributions(SPACE, made, values, [1.0] * 6, ["s"] * 4) if c.switch == "b")
    assert b.db.mean == pytest.approx(0.0)
    assert b.db.low < -1
    assert b.db.high > 1


def test_the_last_round_that_has_a_pair_counts() -> None:
    made = SPACE.compositions()
    clips = np.array([20.0, 25.0])
    values = {(0, k): clips[None] for k in range(len(made))}
    on, off = (next(k for k, c in enumerate(made) if c.options == {"a": "none", "b": b}) for b in ("on", "off"))
    values |= {(1, on): clips[None] + 2, (1, off): clips[None]}
    found = {(c.switch, c.part): c for c in latest(contributions(SPACE, made, values, [1.0] * 6, ["s"] * 2))}
    assert (found["b", "on"].rung, found["b", "on"].db.mean) == (1, 2.0)
    assert found["a", "full"].rung == 0
