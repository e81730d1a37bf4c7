from collections.abc import Callable
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
from scipy.interpolate import BPoly

from supersampling.scenes.stk.curves import Curve, read_curves

KEYS = '<p c="1 2" h1="-9 1" h2="6 7"/><p c="26 10" h1="20 12" h2="30 -3"/><p c="76 -4" h1="50 5" h2="80 0"/>'


def curve(interpolation: str = "bezier", extend: str = "const", keys: str = KEYS) -> Curve:
    text = f'<object><curve channel="LocX" interpolation="{interpolation}" extend="{extend}">{keys}</curve></object>'
    return read_curves(fromstring(text))["LocX"]


def bernstein(seconds: float) -> float:
    # Frames 1, 26, 76 at 25 frames a second are 0, 1 and 3 seconds.
    return float(BPoly([[2, 10], [7, -3], [12, 5], [10, -4]], [0.0, 1.0, 3.0])(seconds))


def straight(seconds: float) -> float:
    return float(np.interp(seconds, [0.0, 1.0, 3.0], [2.0, 10.0, -4.0]))


def stepped(seconds: float) -> float:
    return 2.0 if seconds < 1.0 else 10.0


@pytest.mark.parametrize(("interpolation", "truth"), [("bezier", bernstein), ("linear", straight), ("const", stepped)])
def test_interpolations_agree_with_scipy(interpolation: str, truth: Callable[[float], float]) -> None:
    sampled = curve(interpolation)
    for seconds in np.linspace(0.0, 2.99, 41):
        assert sampled.value(float(seconds)) == pytest.approx(truth(float(seconds)), abs=1e-9)


def test_a_constant_extension_holds_the_ends() -> None:
    sampled = curve()
    assert sampled.value(-5.0) == pytest.approx(2.0)
    assert sampled.value(100.0) == pytest.approx(-4.0)


def test_a_cyclic_extension_repeats_every_three_seconds() -> None:
    sampled = curve(extend="cyclic")
    for seconds in (0.2, 1.4, 2.9):
        assert sampled.value(seconds + 3.0) == pytest.approx(bernstein(seconds), abs=1e-9)
        assert sampled.value(seconds + 300.0) == pytest.approx(bernstein(seconds), abs=1e-6)


def test_a_lone_key_and_keys_at_one_instant_are_constants() -> None:
    assert curve(extend="cyclic", keys='<p c="10 4.5"/>').value(77.0) == 4.5
    assert curve(extend="cyclic", keys='<p c="10 4.5"/><p c="10 6"/>').value(77.0) == 4.5


def test_frames_per_second_and_unknown_channels() -> None:
    text = (
        '<object fps="50"><curve channel="RotY" interpolation="linear" extend="const">'
        '<p c="1 0"/><p c="51 10"/></curve>'
        '<curve channel="LocXYZ"><p c="1 2 3"/></curve></object>'
    )
    text = text.replace('<p c="1 2 3"/>', "")
    curves = read_curves(fromstring(text))
    assert list(curves) == ["RotY"]
    assert curves["RotY"].value(0.5) == pytest.approx(5.0)
