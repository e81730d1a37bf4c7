"""Mutations of scene files for fuzzing: of JSON trees, of text and of bytes, each from a seeded generator."""

import copy
import os
import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

Random = np.random.Generator
EXTREMES: tuple[Any, ...] = (
    *(-1, 0, 1, 2, 3, 7, 255, 65536, 2**31, 2**32 - 1, 2**53, 10**30, 0.5, -2.5, 1e-310, 1e38, 1e308, float("inf")),
    *(None, True, False, "", "x", "0", "SCALAR", "VEC3", "data:,abc", "a.bin", "../a", "\0", "é" * 300),
    *([], {}, [[]], [0], [0, 0, 0], [1e38] * 3, [0.0] * 16, [None], {"extensions": {}}, {"index": 0}, {"count": 2**30}),
)
MEMORY = 2 << 30  # bytes that one file may take besides those in use


def seeds(default: float = 20.0) -> Iterator[int]:
    """Yield 0, 1, 2, ... for as many seconds as ``FUZZ_SECONDS`` says, from ``FUZZ_SEED`` on."""
    end = time.monotonic() + float(os.environ.get("FUZZ_SECONDS", default))
    seed = int(os.environ.get("FUZZ_SEED", 0))
    while time.monotonic() < end:
        yield seed
        seed += 1


@contextmanager
def bounded_memory() -> Iterator[None]:
    """Make allocations of more than `MEMORY` bytes fail."""
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Return a container and key for each value of a tree."""
    places, waiting = [], [tree]
    while waiting:
        item = waiting.pop()
        keys = list(item) if isinstance(item, dict) else range(len(item)) if isinstance(item, list) else ()
        places += [(item, key) for key in keys]
        waiting += [item[key] for key in keys]
    return places


def mutated_tree(tree: Any, random: Random) -> Any:
    """Return a tree with one or two values deleted, replaced, exchanged, nudged, renamed or repeated."""
    tree = copy.deepcopy(tree)
    for _ in range(random.integers(1, 3)):
        places = _places(tree)
        if not places:
            return tree
        item, key = places[random.integers(len(places))]
        source, other = places[random.integers(len(places))]
        match random.integers(6):
            case 0:
                del item[key]
            case 1:
                item[key] = copy.deepcopy(EXTREMES[random.integers(len(EXTREMES))])
            case 2:
                item[key] = copy.deepcopy(source[other])
            case 3 if isinstance(item[key], int | float):
                item[key] = item[key] + int(random.integers(-2, 3))
            case 4 if isinstance(item, dict):
                item[str(other)] = item.pop(key)
            case _ if isinstance(item[key], list):
                item[key] = item[key] * int(random.integers(0, 4))
    return tree


def mutated_bytes(data: bytes, random: Random) -> bytes:
    """Return bytes with some overwritten, removed or inserted, or cut short."""
    out = bytearray(data)
    for _ in range(random.integers(1, 5)):
        if not out:
            break
        start, length = int(random.integers(len(out))), int(random.choice([1, 2, 4, 8]))
        match random.integers(5):
            case 0:
                out[start : start + length] = random.bytes(length)
            case 1:
                out[start : start + length] = bytes([int(random.choice([0, 127, 128, 255]))]) * length
            case 2:
                del out[start : start + length]
            case 3:
                out[start:start] = random.bytes(length)
            case _:
                del out[start:]
    return bytes(out)


def mutated_text(text: str, random: Random, words: tuple[str, ...]) -> str:
    """Return XML text of which some quoted values are replaced by ``words`` or by each other; rarely, anything else."""
    pieces = text.split('"')
    values = range(1, len(pieces), 2) if random.integers(8) and len(pieces) > 2 else range(len(pieces))
    for _ in range(random.integers(1, 4)):
        source = pieces[random.choice(values)] if random.integers(2) else random.choice(words)
        pieces[random.choice(values)] = str(source)
    return '"'.join(pieces)
