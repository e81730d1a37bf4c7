"""Writer of NSRD's layout (`supersampling.data.readers.nsrd`)."""

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

REQUIRED = Nsrd.buffers


def export_nsrd(dataset: DatasetFile, folder: Path) -> None:
    """Write all clips below ``folder``: clip ``k`` becomes folder ``k`` of its split.

    NSRD's remodulation replaces emissive pixels whereas this project adds emission, so ``Emission_Sky`` holds the whole
    radiance of pixels that emit, and 0 elsewhere. All is exact: 32-bit floats, since a quotient may leave the range of
    half floats.

    Raises:
        UserError: the inputs are jittered, which the layout cannot represent.
    """
    if any(dataset.read("jitter", clip, slice(None)).any() for clip in range(dataset.clips)):
        raise UserError(
            f"{dataset.path} has jittered inputs, which NSRD's layout cannot represent: render with task.jitter=none."
        )
    for clip in range(dataset.clips):
        low = folder / dataset.spec.split / low_folder(dataset.spec.scale) / str(clip)
        high = folder / dataset.spec.split / GT / str(clip)
        for t, frame in enumerate(read_frames(dataset, clip, REQUIRED)):
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
