"""Writer of the layout of Arm's NSS data set specification (`supersampling.data.readers.arm`)."""

import json
from pathlib import Path
from typing import Any

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.images import write_exr
from supersampling.data.exporters.source import read_frames
from supersampling.data.readers.arm import Arm, stored_depth

REQUIRED = frozenset({"radiance", "depth", "motion", "jitter", "target_radiance", "high_motion"})
NEAR, FAR = 0.1, 200.0
"""Planes for files that do not record them; linear depth is relative to the planes in any case."""


def export_arm(dataset: DatasetFile, folder: Path) -> None:
    """Write all clips below ``folder / split``: clip ``k`` becomes sequence ``k``.

    Radiance is exact, and jitter up to the rounding of float32. Motion is rounded to half floats; depth becomes a
    32-bit forward depth buffer with an error of 6e-8 far/near at the far plane. Camera matrices are not in data sets
    and are left out.
    """
    base, spec = folder / dataset.spec.split, dataset.spec
    near, far = (float(dataset.attributes.get(key, value)) for key, value in (("near", NEAR), ("far", FAR)))
    width, height = (n // spec.scale for n in spec.target_size)
    for clip in range(dataset.clips):
        entries: list[dict[str, Any]] = []
        for t, frame in enumerate(read_frames(dataset, clip, REQUIRED)):
            low, file = base / f"x{spec.scale}", f"{clip:04d}/{t:04d}.exr"
            write_exr(low / "color" / file, frame["radiance"], "RGB")
            write_exr(low / "depth" / file, stored_depth(frame["depth"], near, far), "R", half=False)
            write_exr(low / "motion" / file, Arm.motion.encode(frame["motion"]), "RG")
            write_exr(base / "ground_truth" / file, frame["target_radiance"], "RGB")
            write_exr(base / "motion_gt" / file, Arm.motion.encode(frame["high_motion"]), "RG")
            x, y = (float(v) for v in Arm.jitter.encode(frame["jitter"]))
            planes = {"CameraNearPlane": near, "CameraFarPlane": far}
            jitter = {"Jitter": {"X": x, "Y": y}, "NormalizedPerRatioJitter": [{"X": x / width, "Y": y / height}]}
            entries.append({"Frame": t, "CameraCut": t == 0, **planes, "Exposure": 1.0, **jitter})
        meta = {
            "Version": "1.0.1",
            "ReverseZ": False,
            "TargetResolution": dict(zip("XY", spec.target_size)),
            "UpscalingRatiosIndices": {f"x{spec.scale}_index": 0},
            "Frames": entries,
        }
        (base / f"{clip:04d}.json").write_text(json.dumps(meta))
