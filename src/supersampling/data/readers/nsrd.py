"""Reader of NSRD's released scenes (Li et al. 2024, supplement, section 4): demodulated lighting as EXR, targets as
PNG.

``{train,val,test}/GT/<folder>/{Irradiance,BRDF,Emission_Sky,View_PNG}/<i>`` and
``{train,val,test}/X<scale>/<folder>/{Irradiance,Normal,Depth,MV,OCMV}/<i>.exr``; the capture's folder is one scene.

The inputs have no BRDF, only the lighting after division by it. The lighting becomes ``radiance`` with ``material`` 1
and ``emission`` 0, so that demodulation returns it. Remodulation replaces ``BRDF * irradiance`` by ``Emission_Sky``
where that exceeds 1e-4: there ``high_material`` is 0 and ``high_emission`` is ``Emission_Sky``. The inputs are not
jittered: jitter is 0.
"""

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.exr import read_exr, read_exr_colors
from supersampling.data.readers.files import Root, frame_numbers
from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip, Conventions, Layout
from supersampling.data.readers.png_images import png_size, read_png_colors
from supersampling.data.readers.units import checked_motion
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError

EMISSIVE = 1e-4
GT = "GT"
LOW = {"radiance": "Irradiance", "normal": "Normal", "depth": "Depth", "motion": "MV", "motion_dual": "OCMV"}
HIGH = {"irradiance": "Irradiance", "brdf": "BRDF", "emission": "Emission_Sky"}
TARGET = "View_PNG"


def low_folder(scale: int) -> str:
    return f"X{scale}"


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

    def __init__(self, root: Root, scale: int, conventions: Conventions) -> None:
        super().__init__(root, scale, conventions)
        self.depth_range = 1.0

    def notes(self) -> dict[str, str]:
        return {
            "attribution": "NSRD data set (Li et al. 2024); see its licence",
            "tonemap": "sRGB curve",
            "demodulated": "yes: radiance is the lighting component; material is 1",
            "depth_unit": f"captured depth / {self.depth_range:g}",
            "normal_axes": "as captured",
        }

    def clips(self) -> list[CaptureClip]:
        clips: list[NsrdClip] = []
        for split in SPLITS:
            low, high = (self.root.folders(split, kind) for kind in (low_folder(self.scale), GT))
            if high and not low:
                print(f"{self.root.path / split} has no {low_folder(self.scale)}: {split} is left out.")
            clips += [NsrdClip(self, split, folder) for folder in sorted({*low, *high} if low else ())]
        if not clips:
            raise UserError(
                f"{self.root.path} has no clips in the layout <train or "
                f"test>/{low_folder(self.scale)}/<folder>/Irradiance: "
                "set path to the folder of a scene, and task.scale to one of its scales."
            )
        self.depth_range = self._measure_depth_range(clips)
        return list(clips)

    def _measure_depth_range(self, clips: list["NsrdClip"]) -> float:
        """Return 1 for depth in [0, 1], else the power of ten above each clip's first frame: the unit is not
        documented."""
        largest = max(float(clip.stored_depth(0).max()) for clip in clips)
        return 1.0 if largest <= 1.0 else 10.0 ** math.ceil(math.log10(largest))


class NsrdClip(CaptureClip):
    """The clip of one numbered folder of a split."""

    def __init__(self, layout: Nsrd, split: str, folder: str) -> None:
        self._layout, root = layout, layout.root
        low, high = Path(split, low_folder(layout.scale), folder), Path(split, GT, folder)
        self._streams = {name: root.frames(low / kind, ".exr") for name, kind in LOW.items()}
        self._streams |= {name: root.frames(high / kind, ".exr") for name, kind in HIGH.items()}
        self._streams["target"] = root.frames(high / TARGET, ".png")
        self._numbers = frame_numbers(self._streams)
        size = png_size(self._streams["target"][self._numbers[0]])
        super().__init__(f"nsrd/{root.name}", split, str(low), size)
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

    def stored_depth(self, t: int) -> Image:
        """Return depth as captured, ``(h, w, 1)``, at least 0."""
        path = self._streams["depth"][self._numbers[t]]
        depth = read_exr(path, self._low_size, ("R", "Y", "Z"))
        if depth.min() < 0.0:
            raise UserError(
                f"{path} has negative depths, down to {depth.min():.4g}: export depth that grows away from the camera."
            )
        return depth

    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        paths = {name: stream[self._numbers[t]] for name, stream in self._streams.items()}
        out: dict[str, Image] = {}
        if "radiance" in names:
            out["radiance"] = np.maximum(read_exr_colors(paths["radiance"], self._low_size), 0.0)
        if "normal" in names:
            out["normal"] = read_exr(paths["normal"], self._low_size, ("RGB", "XYZ"))
        if "depth" in names:
            depth = np.minimum(self.stored_depth(t) / np.float32(self._layout.depth_range), 1.0)
            out["depth"] = 1.0 - depth if self._layout.conventions.reversed_depth else depth
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
        irradiance, brdf, emission = (np.maximum(read_exr_colors(paths[n], self.size), 0.0) for n in HIGH)
        emissive = emission > EMISSIVE
        material, emission = (np.where(emissive, np.float32(0.0), brdf), np.where(emissive, emission, np.float32(0.0)))
        return {
            "target_radiance": material * irradiance + emission,
            "high_material": material,
            "high_emission": emission,
        }
