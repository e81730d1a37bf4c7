"""Reader of NSRD's released scenes (Li et al. 2024, supplement, section 4): demodulated lighting as EXR, targets as
PNG.

``{train,val,test}/GT/<folder>/{Irradiance,BRDF,Emission_Sky,View_PNG}/<i>`` and
``{train,val,test}/X<scale>/<folder>/{Irradiance,Normal,Depth,MV,OCMV}/<i>.exr``; the capture's folder is one scene.
Normals, dual motion and what remodulates the target are optional, for all clips or none.

The inputs have no BRDF, only the lighting after division by it. The lighting becomes ``radiance`` with ``material`` 1
and ``emission`` 0, so that demodulation returns it. Remodulation replaces ``BRDF * irradiance`` by ``Emission_Sky``
where that exceeds 1e-4: there ``high_material`` is 0 and ``high_emission`` is ``Emission_Sky``. The inputs are not
jittered: jitter is 0.
"""

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.exr import read_exr, read_exr_colors
from supersampling.data.readers.files import Root, frame_numbers
from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip, Conventions, Layout
from supersampling.data.readers.png_images import png_size, read_png_colors
from supersampling.data.readers.sky import DepthScale, measure_depth
from supersampling.data.readers.units import checked_light, checked_motion, checked_normal
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError

EMISSIVE = 1e-4
GT = "GT"
LOW = {"radiance": "Irradiance", "normal": "Normal", "depth": "Depth", "motion": "MV", "motion_dual": "OCMV"}
HIGH = {"irradiance": "Irradiance", "brdf": "BRDF", "emission": "Emission_Sky"}
TARGET = "View_PNG"
REMODULATION = f"GT/<folder>/{{{','.join(HIGH.values())}}}"
PARTS = {"Normal": ("normal",), "OCMV": ("motion_dual",), REMODULATION: tuple(HIGH)}
"""The files that each optional part of a capture consists of."""


def low_folder(scale: int) -> str:
    return f"X{scale}"


def stream_folders(split: str, folder: str, scale: int) -> dict[str, Path]:
    """Return the folder of each kind of file of a clip, by its name in `LOW`, in `HIGH` or ``target``."""
    low, high = Path(split, low_folder(scale), folder), Path(split, GT, folder)
    paths = {name: low / kind for name, kind in LOW.items()} | {name: high / kind for name, kind in HIGH.items()}
    return paths | {"target": high / TARGET}


class Nsrd(Layout):
    """The layout of the module's docstring.

    The previous position is position - mv (the released code), so motion is ``-mv``, x right, y down.
    """

    motion = Convention("-x-y")
    jitter = Convention("xy")
    buffers = frozenset(
        {
            *("radiance", "material", "emission", "normal", "depth", "motion", "motion_dual", "jitter"),
            *("target", "target_radiance", "high_material", "high_emission"),
        }
    )
    optional: ClassVar = {
        "Normal": frozenset({"normal"}),
        "OCMV": frozenset({"motion_dual"}),
        REMODULATION: frozenset({"target_radiance", "high_material", "high_emission"}),
    }

    def __init__(self, root: Root, scale: int, conventions: Conventions) -> None:
        super().__init__(root, scale, conventions)
        self._clips: list[NsrdClip] = []

    def notes(self) -> dict[str, str]:
        return {
            "attribution": "NSRD data set (Li et al. 2024); see its licence",
            "tonemap": "sRGB curve",
            "demodulated": "yes: radiance is the lighting component; material is 1",
            "depth_unit": f"captured depth / {self.depth_scale.unit:g}",
            "depth_sky": ", ".join(f"{mark:g}" for mark in sorted(self.depth_scale.marks)) or "no mark",
            "normal_axes": "as captured",
        }

    def clips(self) -> list[CaptureClip]:
        folders: list[tuple[str, str]] = []
        for split in SPLITS:
            low, high = (self.root.folders(split, kind) for kind in (low_folder(self.scale), GT))
            if high and not low:
                print(f"{self.root.path / split} has no {low_folder(self.scale)}: {split} is left out.")
            folders += [(split, folder) for folder in sorted({*low, *high} if low else ())]
        if not folders:
            raise UserError(
                f"{self.root.path} has no clips in the layout <train or "
                f"test>/{low_folder(self.scale)}/<folder>/Irradiance: "
                "set path to the folder of a scene, and task.scale to one of its scales."
            )
        streams = [stream_folders(split, folder, self.scale) for split, folder in folders]
        self.leave_out(
            part
            for part, names in PARTS.items()
            if any(all(not self.root.inside(clip[name]).is_dir() for clip in streams) for name in names)
        )
        self._clips = [NsrdClip(self, split, folder) for split, folder in folders]
        return list(self._clips)

    @cached_property
    def depth_scale(self) -> DepthScale:
        """Return the scale of depth, from all frames of all clips: a later frame may show what is farthest."""
        files = (clip.stored_depth(t) for clip in self._clips for t in range(clip.frames))
        return measure_depth(files, bool(self.conventions.reversed_depth))

    def summary(self) -> list[str]:
        return [f"{self.root.name}: {self.depth_scale.summary()}."]


class NsrdClip(CaptureClip):
    """The clip of one numbered folder of a split."""

    def __init__(self, layout: Nsrd, split: str, folder: str) -> None:
        self._layout, root = layout, layout.root
        absent = {name for part in layout.absent for name in PARTS[part]}
        self._streams = {
            name: root.frames(path, ".png" if name == "target" else ".exr")
            for name, path in stream_folders(split, folder, layout.scale).items()
            if name not in absent
        }
        self._numbers = frame_numbers(self._streams)
        size = png_size(self._streams["target"][self._numbers[0]])
        super().__init__(f"nsrd/{root.name}", split, str(Path(split, low_folder(layout.scale), folder)), size)
        if size[0] % layout.scale or size[1] % layout.scale:
            raise UserError(
                f"{self._streams['target'].folder} has images of {size[0]}x{size[1]} pixels, not a multiple of the "
                "scale "
                f"{layout.scale}: correct task.scale."
            )
        self._low_size = (size[0] // layout.scale, size[1] // layout.scale)

    @property
    def frames(self) -> int:
        return len(self._numbers)

    def files(self) -> Iterable[Path]:
        for stream in self._streams.values():
            yield from (stream[k] for k in self._numbers)

    def stored_depth(self, t: int) -> tuple[Path, Image]:
        """Return the file and its depth as captured, ``(h, w, 1)``."""
        path = self._streams["depth"][self._numbers[t]]
        return path, read_exr(path, self._low_size, ("R", "Y", "Z"), infinite=True)

    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        paths = {name: stream[self._numbers[t]] for name, stream in self._streams.items()}
        out: dict[str, Image] = {}
        if "radiance" in names:
            out["radiance"] = self._read_light("radiance", paths, self._low_size)
        if "normal" in names:
            out["normal"] = checked_normal(read_exr(paths["normal"], self._low_size, ("RGB", "XYZ")), paths["normal"])
        if "depth" in names:
            _, depth = self.stored_depth(t)
            out["depth"] = self._layout.depth_scale.decode(depth, bool(self._layout.conventions.reversed_depth))
        for name in sorted(names & {"motion", "motion_dual"}):
            stored = read_exr(paths[name], self._low_size, ("RG", "XY"))
            out[name] = checked_motion(self._layout.conventions.motion.decode(stored), paths[name])
        if "target" in names:
            out["target"] = read_png_colors(paths["target"], self.size)
        if names & {"target_radiance", "high_material", "high_emission"}:
            out |= self._light(paths)
        width, height = self._low_size
        flat = np.ones((height, width, 3), dtype=np.float32)
        out |= {"material": flat, "emission": 0.0 * flat, "jitter": np.zeros(2, dtype=np.float32)}
        return {name: image for name, image in out.items() if name in names}

    def _light(self, paths: dict[str, Path]) -> dict[str, Image]:
        """Return the target's radiance and its parts, as NSRD remodulates them."""
        irradiance, brdf, emission = (self._read_light(name, paths, self.size) for name in HIGH)
        emissive = emission > EMISSIVE
        material, emission = (np.where(emissive, np.float32(0.0), brdf), np.where(emissive, emission, np.float32(0.0)))
        return {
            "target_radiance": material * irradiance + emission,
            "high_material": material,
            "high_emission": emission,
        }

    @staticmethod
    def _read_light(name: str, paths: dict[str, Path], size: tuple[int, int]) -> Image:
        return checked_light(read_exr_colors(paths[name], size), paths[name])
