"""Writer of QRISP's layout (`supersampling.data.readers.qrisp`): jittered inputs, camera data and the target."""

import json
from pathlib import Path

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.images import write_exr, write_png, write_png8
from supersampling.data.exporters.source import read_frames, scene_name
from supersampling.data.readers.camera_data import KEY
from supersampling.data.readers.qrisp import (
    CAMERA,
    RESOLUTIONS,
    SPLITS,
    TARGET,
    Qrisp,
    check_scale,
    encode_depth,
    modality,
)

REQUIRED = Qrisp.buffers


def export_qrisp(dataset: DatasetFile, folder: Path) -> None:
    """Write all clips below ``folder``: clip ``k`` becomes segment ``k``; splits other than test go to ``TrainSet``.

    Colour, target, jitter (in float32) and depth above 0.004 are exact; smaller depth has errors up to 1.3e-10. Motion
    is rounded to half floats (relative 5e-4). Folder names state 1080p whatever the size.
    """
    scale = dataset.spec.scale
    check_scale(scale)
    set_name = next((name for name, split in SPLITS.items() if split == dataset.spec.split), "TrainSet")
    base = folder / set_name / scene_name(dataset)
    low = base / RESOLUTIONS[scale][0]
    for clip in range(dataset.clips):
        segment = f"{clip:04d}"
        for t, frame in enumerate(read_frames(dataset, clip, REQUIRED)):
            write_png(low / modality("", scale) / segment / f"{t:04d}.png", frame["color"])
            write_png8(low / modality("Depth", scale) / segment / f"{t:04d}.png", encode_depth(frame["depth"]))
            motion = Qrisp.motion.encode(frame["motion"])
            write_exr(low / modality("MotionVectors", scale) / segment / f"{t:04d}.exr", motion, "RG")
            write_png(base.joinpath(*TARGET) / segment / f"{t:04d}.png", frame["target"])
            x, y = Qrisp.jitter.encode(frame["jitter"]).tolist()
            camera = low / CAMERA / segment / f"{t:04d}.json"
            camera.parent.mkdir(parents=True, exist_ok=True)
            camera.write_text(json.dumps({KEY: {"x": x, "y": y}}))
