"""Sizes from 1x1 to 8K, odd and elongated ones, and scales from 1 to 8."""

from supersampling.stress.extreme import Extreme

EIGHT_K = 7680, 4320
SIZES = (
    Extreme("size/1x1", "One low-resolution pixel.", size=(1, 1)),
    Extreme("size/2x1", "Two pixels, one row.", size=(2, 1)),
    Extreme("size/odd", "13x7, which no network's blocks divide.", size=(13, 7)),
    Extreme("size/prime", "31x29, odd on both axes and larger than any window.", size=(31, 29)),
    Extreme("size/1:100", "Aspect 1:100, 2x200.", size=(2, 200)),
    Extreme("size/100:1", "Aspect 100:1, 200x2.", size=(200, 2)),
    Extreme("size/8K wide", "A strip as wide as an 8K target.", target=(EIGHT_K[0], 8), frames=3),
    Extreme("size/8K tall", "A strip as tall as an 8K target.", target=(8, EIGHT_K[1]), frames=3),
    Extreme("size/8K target", "A whole target of 7680x4320.", target=EIGHT_K, frames=2, full=True),
    Extreme("size/8K input", "A whole input of 7680x4320.", size=EIGHT_K, frames=2, full=True),
    Extreme(
        "size/8K input at scale 1", "An input and a target of 7680x4320.", size=EIGHT_K, scale=1, frames=2, full=True
    ),
)
SCALES = tuple(
    Extreme(f"scale/{s}", f"{s}x{s} target pixels per input pixel.", scale=s, full=s in (5, 6, 7)) for s in range(1, 9)
)
