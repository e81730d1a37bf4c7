"""Register of small files, one for each row of the tables in docs/gltf.md."""

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from gltf_files import Builder

from supersampling.scenes.gltf.features import Deviation


@dataclass(frozen=True)
class Case:
    """Row of the tables.

    ``build(file)`` writes a file with a warning or an error, whose words are given; ``build(file, plain)`` a file and
    one that must look the same and does without the feature.
    """

    row: str
    build: Callable[..., None]
    warning: str = ""
    error: str = ""


CASES: list[Case] = []


def case(row: str, warning: Deviation | str = "", error: str = "") -> Callable[[Callable[..., None]], Any]:
    """Register a function that writes the file of a row."""

    def register(build: Callable[..., None]) -> Callable[..., None]:
        CASES.append(Case(row, build, str(warning), error))
        return build

    return register


def patched(file: Builder, accessor: int, changes: dict[int, float]) -> None:
    """Overwrite numbers of a float accessor."""
    start = file.json["bufferViews"][file.json["accessors"][accessor]["bufferView"]]["byteOffset"]
    blob = bytearray(file.blob)
    for index, value in changes.items():
        struct.pack_into("<f", blob, start + 4 * index, value)
    file.blob = bytes(blob)


def quarter(axis: int) -> list[float]:
    """Return the quaternion of a quarter turn about an axis."""
    half = float(np.sqrt(0.5))
    return [half if k == axis else 0.0 for k in range(3)] + [half]
