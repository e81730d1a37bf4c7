"""The JSON of a sequence of Arm's layout (`supersampling.data.readers.arm`)."""

from pathlib import Path
from typing import Any

import numpy as np

from supersampling.data.readers.files import Frames, number
from supersampling.data.readers.images import Image
from supersampling.errors import UserError


def read_entries(meta: Any, path: Path) -> list[dict[str, Any]]:
    """Return the frames of a sequence's JSON; raise `UserError` if it is not as specified."""
    entries = meta.get("Frames") if isinstance(meta, dict) else None
    entries = entries if isinstance(entries, list) and all(isinstance(e, dict) for e in entries) else None
    if entries is None or not isinstance(meta.get("ReverseZ"), bool):
        raise UserError(f"{path} has no list Frames or no boolean ReverseZ: write both as in the specification.")
    for before, entry in zip([None, *entries], entries):
        cut = entry.get("CameraCut", False)
        if not isinstance(cut, bool):
            raise UserError(f"Invalid CameraCut in {path} ({str(cut)[:40]!r}): write true or false.")
        frame, previous = entry.get("Frame"), before.get("Frame") if before else None
        if type(frame) is int and type(previous) is int and frame != previous + 1:
            raise UserError(f"{path} describes frame {frame} after frame {previous}: list every frame once, in order.")
    return entries


class ArmSequence:
    """The common parts of a sequence's clips: its JSON and its files."""

    def __init__(self, path: Path, meta: dict[str, Any], streams: dict[str, Frames]) -> None:
        self.path, self.streams = path, streams
        self.reversed_z: bool = meta["ReverseZ"]
        self._indices = meta.get("UpscalingRatiosIndices")

    def read_jitter(self, entry: dict[str, Any], scale: int) -> Image:
        """Return the frame's normalised jitter ``(2,)`` at a scale, as stored."""
        ratios = entry.get("NormalizedPerRatioJitter")
        index = self._indices.get(f"x{scale}_index") if isinstance(self._indices, dict) else 0
        if not isinstance(ratios, list) or type(index) is not int or not 0 <= index < len(ratios):
            raise UserError(
                f"{self.path} has no NormalizedPerRatioJitter for x{scale}: restore it, inputs without jitter cannot "
                "be used."
            )
        return np.array([number(ratios[index], axis, self.path) for axis in "XY"], dtype=np.float32)
