"""Mutations of scene files for fuzzing: of JSON trees, of text and of bytes, each from a seeded generator."""

import copy
import resource
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import trials

from supersampling.errors import UserError

Random = np.random.Generator
EXTREMES: tuple[Any, ...] = (
    *(-1, 0, 1, 2, 3, 7, 255, 65536, 2**31, 2**32 - 1, 2**53, 10**30, 0.5, -2.5, 1e-310, 1e38, 1e308, float("inf")),
    *(None, True, False, "", "x", "0", "SCALAR", "VEC3", "data:,abc", "a.bin", "../a", "\0", "é" * 300),
    *([], {}, [[]], [0], [0, 0, 0], [1e38] * 3, [0.0] * 16, [None], {"extensions": {}}, {"index": 0}, {"count": 2**30}),
)
MEMORY = 2 << 30  # bytes that one file may take besides those in use


def check_mutations(load: Callable[[int], None], place: Path) -> None:
    """Load a mutated file for each seed: a scene or one line of `UserError`, and both occur; ``place`` has them."""
    scenes = count = 0
    for seed in trials():
        count += 1
        try:
            with warnings.catch_warnings(), bounded_memory():
                warnings.simplefilter("ignore")
                load(seed)
            scenes += 1
        except UserError as error:
            if "\n" in str(error):
                pytest.fail(f"seed {seed}, {place}: {error}")
        except BaseException:
            print(f"seed {seed}; the files are in {place}")
            raise
    print(f"{count} inputs, {scenes} scenes")
    assert scenes > 0.05 * count
    assert scenes < 0.95 * count


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
