"""Writes NSRD's layout (`supersampling.data.readers.nsrd`)."""

from pathlib import Path

import numpy as np
import torch

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.images import write_exr, write_png
from supersampling.data.exporters.source import read_frames
from supersampling.data.readers.images import Image
from supersampling.data.readers.nsrd import EMISSIVE, GT, TARGET, Nsrd, low_folder
from supersampling.errors import UserError
from supersampling.ops.demodulate import demodulate

NEEDED = frozenset(
    {
        "radiance", "material", "emission", "normal", "depth", "motion", "motion_dual", "jitter", "target",
        "target_radiance", "high_material", "high_emission",
    }
)  # fmt: skip


def export_nsrd(store: DatasetFile, folder: Path) -> None:
    """All clips below ``folder``: clip ``k`` becomes folder ``k`` of its split.

    NSRD's remodulation replaces where ours adds, so ``Emission_Sky`` holds the whole radiance of pixels that emit, and 0
    elsewhere. 32-bit floats, since a quotient may leave the range of half floats: all is exact.

    Raises:
        UserError: the inputs are jittered, for which the layout has no place.
    """
    if any(store.read("jitter", clip, slice(None)).any() for clip in range(store.clips)):
        raise UserError(
            f"{store.path} has jittered inputs, and NSRD's layout has no place for jitter: render with task.jitter=none."
        )
    for clip in range(store.clips):
        low = folder / store.spec.split / low_folder(store.spec.scale) / str(clip)
        high = folder / store.spec.split / GT / str(clip)
        for t, frame in enumerate(read_frames(store, clip, NEEDED)):
            file = f"{t}.exr"
            lighting = _lighting(frame["radiance"], frame["material"], frame["emission"])
            write_exr(low / "Irradiance" / file, lighting, "RGB", half=False)
            write_exr(low / "Normal" / file, frame["normal"], "RGB", half=False)
            write_exr(low / "Depth" / file, frame["depth"], "R", half=False)
            write_exr(low / "MV" / file, Nsrd.motion.encode(frame["motion"]), "RG", half=False)
            write_exr(low / "OCMV" / file, Nsrd.motion.encode(frame["motion_dual"]), "RG", half=False)
            radiance, material, emission = (frame[n] for n in ("target_radiance", "high_material", "high_emission"))
            write_exr(high / "Irradiance" / file, _lighting(radiance, material, emission), "RGB", half=False)
            write_exr(high / "BRDF" / file, material, "RGB", half=False)
            shown = np.where(emission > EMISSIVE, radiance, np.float32(0.0))
            write_exr(high / "Emission_Sky" / file, shown, "RGB", half=False)
            write_png(high / TARGET / f"{t}.png", frame["target"])


def _lighting(radiance: Image, material: Image, emission: Image) -> Image:
    tensors = (torch.from_numpy(image.transpose(2, 0, 1))[None] for image in (radiance, material, emission))
    return demodulate(*tensors)[0].numpy().transpose(1, 2, 0)
