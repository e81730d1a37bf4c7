"""Seeded trials until a time is up; each failure has its seed and its input."""

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np


def trials(share: float = 1.0) -> Iterator[int]:
    """Yield seeds from FUZZ_SEED (0) on, for this share of the FUZZ_SECONDS (20): environment variables."""
    end = time.monotonic() + share * float(os.environ.get("FUZZ_SECONDS", "20"))
    seed = int(os.environ.get("FUZZ_SEED", "0"))
    while time.monotonic() < end:
        yield seed
        seed += 1


def mutate(content: bytes, rng: np.random.Generator) -> bytes:
    """Return bytes with a few flipped bits, a range of zeros or noise, a part that is missing, or only their start."""
    data = bytearray(content)
    kind = rng.integers(6)
    start = int(rng.integers(len(data)))
    length = int(min(2 ** rng.integers(1, 12), len(data) - start))
    if kind <= 1:
        for _ in range(int(rng.integers(1, 4))):
            data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    elif kind == 2:
        data[start : start + length] = bytes(length)
    elif kind == 3:
        data[start : start + length] = rng.bytes(length)
    elif kind == 4:
        del data[start : start + length]
    else:
        del data[start:]
    return bytes(data)


def is_sentence(error: Exception) -> bool:
    """Fail unless a message is one line that says what to do."""
    message = str(error)
    assert ": " in message, message
    assert "\n" not in message, message
    return True


def attempt(seed: int, path: Path, kept: Path, check: Callable[[], None]) -> None:
    """Run a check; an error gets a note with the seed and the place to which the input is copied."""
    try:
        check()
    except BaseException as error:
        kept.write_bytes(path.read_bytes())
        error.add_note(f"FUZZ_SEED={seed}, input {kept}")
        raise
