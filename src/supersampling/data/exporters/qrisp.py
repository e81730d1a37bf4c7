"""Writes QRISP's layout (`supersampling.data.readers.qrisp`): jittered colour, depth and motion, camera data and the target."""

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

NEEDED = Qrisp.buffers


def export_qrisp(store: DatasetFile, folder: Path) -> None:
    """All clips below ``folder``: clip ``k`` becomes segment ``k``; what is no test split goes to ``TrainSet``.

    Exact: colour, target, jitter to float32, depth above 0.004 (below to 1.3e-10). Motion is rounded to half floats (relative
    5e-4). Folders are named for 1080p whatever the size.
    """
    scale = store.spec.scale
    check_scale(scale)
    set_name = next((name for name, split in SPLITS.items() if split == store.spec.split), "TrainSet")
    base = folder / set_name / scene_name(store)
    low = base / RESOLUTIONS[scale][0]
    for clip in range(store.clips):
        segment = f"{clip:04d}"
        for t, frame in enumerate(read_frames(store, clip, NEEDED)):
            write_png(low / modality("", scale) / segment / f"{t:04d}.png", frame["color"])
            write_png8(low / modality("Depth", scale) / segment / f"{t:04d}.png", encode_depth(frame["depth"]))
            motion = Qrisp.motion.encode(frame["motion"])
            write_exr(low / modality("MotionVectors", scale) / segment / f"{t:04d}.exr", motion, "RG")
            write_png(base.joinpath(*TARGET) / segment / f"{t:04d}.png", frame["target"])
            x, y = Qrisp.jitter.encode(frame["jitter"]).tolist()
            camera = low / CAMERA / segment / f"{t:04d}.json"
            camera.parent.mkdir(parents=True, exist_ok=True)
            camera.write_text(json.dumps({KEY: {"x": x, "y": y}}))
