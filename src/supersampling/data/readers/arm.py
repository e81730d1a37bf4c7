"""Reader of Arm neural graphics captures (NSS data set specification 1.0.1): linear HDR images, one JSON per sequence.

``<NNNN>.json``, ``ground_truth/<NNNN>/<frame>.exr`` and ``x<scale>/{color,depth,motion}/<NNNN>/<frame>.exr``, below the
capture's folder or below ``train``, ``val`` and ``test`` in it. ``motion_gt/<NNNN>/<frame>.exr`` is optional, for all
sequences or none.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import torch

from supersampling.data.readers.arm_sequence import ArmSequence, read_entries
from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.exr import exr_size, read_exr, read_exr_colors
from supersampling.data.readers.files import Root, frame_numbers, number, read_json
from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip, Conventions, Layout
from supersampling.data.readers.units import checked_jitter, checked_light, checked_motion
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError
from supersampling.ops.display import radiance_to_display

INFINITE_FAR = 5000.0
"""The distance that replaces an infinite far plane, as in Arm's reader; the depth of points beyond it is 1."""

FARTHEST = 1e9
"""Larger planes and exposures, and their inverses, are mistakes; 32-bit floats could not carry the result."""


def linear_depth(stored: Image, near: float, far: float, reversed_z: bool) -> Image:
    """Return a depth buffer in [0, 1] as linear view depth, 0 at the near and 1 at the far plane; ``far=-1`` is
    infinite.

    With ``e`` the stored depth that is 1 near and 0 far, view depth is ``near far / (near + e (far - near))``.
    """
    e = stored if reversed_z else 1.0 - stored
    if far != -1.0:
        return near * (1.0 - e) / (near + e * (far - near))
    depth = near / np.maximum(e, near / INFINITE_FAR)
    linear: Image = ((depth - near) / (INFINITE_FAR - near)).astype(np.float32)
    return linear


def stored_depth(depth: Image, near: float, far: float) -> Image:
    """Return the inverse of `linear_depth` for a finite far plane, forward (0 near), as the specification prefers."""
    exact = depth.astype(np.float64)
    return (1.0 - near * (1.0 - exact) / (near + exact * (far - near))).astype(np.float32)


HIGH_MOTION = "motion_gt"


class Arm(Layout):
    """The layout of the module's docstring.

    Motion is ``current - previous`` in units of the image, x right and y down (Arm's notes on conventions:
    ``query = grid - flow``); the sample lies at the pixel's centre plus jitter (Arm's capture guide).
    """

    motion = Convention("-x-y")
    jitter = Convention("xy")
    buffers = frozenset({"color", "radiance", "depth", "motion", "jitter", "target", "target_radiance", "high_motion"})
    optional: ClassVar = {HIGH_MOTION: frozenset({"high_motion"})}

    def __init__(self, root: Root, scale: int, conventions: Conventions) -> None:
        super().__init__(root, scale, conventions)
        self._clips: list[ArmClip] = []

    def notes(self) -> dict[str, str]:
        return {
            "attribution": "capture in the layout of Arm's NSS data set specification; see its licence",
            "tonemap": "aces_narkowicz, of target_radiance for the target",
            "far_plane": f"infinite ones count as {INFINITE_FAR:g}",
        }

    def summary(self) -> list[str]:
        """Return a line with the planes and exposures that the JSON files state, which nothing else confirms."""
        stated = [values for clip in self._clips for values in clip.stated()]
        texts = []
        for name, values in zip(("near plane", "far plane", "exposure"), zip(*stated)):
            texts.append(f"{name} {' to '.join(f'{value:g}' for value in sorted({min(values), max(values)}))}")
        return [f"{self.root.name}: the JSON files state {', '.join(texts)}."]

    def clips(self) -> list[CaptureClip]:
        clips: list[ArmClip] = []
        name = self.root.name.lower()
        splits = (("", name if name in SPLITS else "train"), *((s, s) for s in SPLITS))
        if not any(self.root.folders(folder, HIGH_MOTION) for folder, _ in splits):
            self.absent = frozenset({HIGH_MOTION})
        for folder, split in splits:
            base = self.root.inside(folder)
            for sequence in self.root.folders(folder, f"x{self.scale}", "color"):
                if not (base / f"{sequence}.json").is_file():
                    raise UserError(
                        f"{base / sequence}.json is missing: restore it for the frames of sequence {sequence}."
                    )
            for path in sorted(base.glob("*.json")):
                if path.stem.isascii() and path.stem.isdigit():
                    clips += self._sequence(base, path, split)
        if not clips:
            raise UserError(f"{self.root.path} has no sequences named <number>.json: set path to their folder.")
        self.leave_out(self.absent)
        self._clips = clips
        return list(clips)

    def _sequence(self, base: Path, path: Path, split: str) -> list["ArmClip"]:
        meta = read_json(self.root.inside(path))
        entries = read_entries(meta, path)
        names = {"color": "color", "depth": "depth", "motion": "motion"}
        streams = {
            name: self.root.frames(base / f"x{self.scale}" / kind / path.stem, ".exr") for name, kind in names.items()
        }
        streams["target"] = self.root.frames(base / "ground_truth" / path.stem, ".exr")
        if HIGH_MOTION not in self.absent:
            streams["high_motion"] = self.root.frames(base / HIGH_MOTION / path.stem, ".exr")
        numbers = frame_numbers(streams)
        if len(numbers) != len(entries):
            raise UserError(
                f"{path} describes {len(entries)} frames, but {len(numbers)} exist: restore the missing frames."
            )
        cuts = [k for k, entry in enumerate(entries) if k and entry.get("CameraCut") is True]
        sequence = ArmSequence(path, meta, streams)
        return [
            ArmClip(self, split, sequence, numbers[start:stop], entries[start:stop])
            for start, stop in zip([0, *cuts], [*cuts, len(numbers)])
        ]


class ArmClip(CaptureClip):
    """Consecutive frames of a sequence between two camera cuts."""

    def __init__(
        self, layout: Arm, split: str, sequence: ArmSequence, numbers: list[int], entries: list[dict[str, Any]]
    ) -> None:
        self._sequence, self._numbers, self._entries = sequence, numbers, entries
        self._conventions, self._scale = layout.conventions, layout.scale
        size = exr_size(sequence.streams["target"][numbers[0]])
        low = exr_size(sequence.streams["color"][numbers[0]])
        if (low[0] * layout.scale, low[1] * layout.scale) != size:
            raise UserError(
                f"{sequence.streams['color'][numbers[0]]} has {low[0]}x{low[1]} pixels, which times {layout.scale} is "
                "not the "
                f"size {size[0]}x{size[1]} of the ground truth: correct task.scale."
            )
        self._low_size = low
        label = str(sequence.path.relative_to(layout.root.path).with_suffix("")) + f"/{numbers[0]:04d}"
        super().__init__(f"arm/{layout.root.name}", split, label, size)

    @property
    def frames(self) -> int:
        return len(self._numbers)

    def files(self) -> Iterable[Path]:
        yield self._sequence.path
        for stream in self._sequence.streams.values():
            yield from (stream[k] for k in self._numbers)

    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        entry = self._entries[t]
        paths = {name: stream[self._numbers[t]] for name, stream in self._sequence.streams.items()}
        out: dict[str, Image] = {}
        for shown, light, source, size in (
            ("color", "radiance", "color", self._low_size),
            ("target", "target_radiance", "target", self.size),
        ):
            if names & {shown, light}:
                radiance = checked_light(read_exr_colors(paths[source], size), paths[source])
                radiance = radiance * np.float32(self._exposure(entry))
                out |= {light: radiance, shown: radiance_to_display(torch.from_numpy(radiance)).numpy()}
        if "depth" in names:
            out["depth"] = self._depth(paths["depth"], entry)
        for name, size in (("motion", self._low_size), ("high_motion", self.size)):
            if name in names:
                stored = read_exr(paths[name], size, ("RG", "XY"))
                out[name] = checked_motion(self._conventions.motion.decode(stored), paths[name])
        if "jitter" in names:
            stored = self._sequence.read_jitter(entry, self._scale) * np.array(self._low_size, dtype=np.float32)
            out["jitter"] = checked_jitter(self._conventions.jitter.decode(stored), self._sequence.path)
        return {name: image for name, image in out.items() if name in names}

    def stated(self) -> list[tuple[float, float, float]]:
        """Return the near plane, the far plane and the exposure of each frame; errors as in `read`."""
        return [(*self._planes(entry), self._exposure(entry)) for entry in self._entries]

    def _exposure(self, entry: dict[str, Any]) -> float:
        exposure = number(entry, "Exposure", self._sequence.path) if "Exposure" in entry else 1.0
        if not 1.0 / FARTHEST <= exposure <= FARTHEST:
            raise UserError(
                f"Invalid Exposure={exposure:g} in {self._sequence.path}: use a positive number, at most {FARTHEST:g}."
            )
        return exposure

    def _planes(self, entry: dict[str, Any]) -> tuple[float, float]:
        near, far = (number(entry, key, self._sequence.path) for key in ("CameraNearPlane", "CameraFarPlane"))
        if near < 1.0 / FARTHEST or not (far == -1.0 or near < far <= FARTHEST):
            raise UserError(
                f"Invalid CameraNearPlane={near:g} and CameraFarPlane={far:g} in {self._sequence.path}: use "
                "0 < near < far, or -1 for an infinite far plane."
            )
        return near, far

    def _depth(self, path: Path, entry: dict[str, Any]) -> Image:
        near, far = self._planes(entry)
        stored = read_exr(path, self._low_size, ("R", "Y", "Z"))
        if stored.min() < 0.0 or stored.max() > 1.0:
            raise UserError(
                f"{path} has depths from {stored.min():.4g} to {stored.max():.4g}: export values between 0 and 1."
            )
        override = self._conventions.reversed_depth
        return linear_depth(stored, near, far, self._sequence.reversed_z if override is None else override)
