"""Reader of QRISP (Mercier et al. 2023, annex A): 8-bit images, depth in four channels, half-float motion, JSON per
frame.

``{TrainSet|TestSet}/<Scene>/<resolution>/<Modality>/<segment>/<frame>.<ext>``; the jittered modalities with mip bias
-log2(scale) become the inputs, ``1080p/Enhanced`` the target.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.data.readers.camera_data import Jitters
from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.exr import read_exr
from supersampling.data.readers.files import Frames, Root, frame_numbers
from supersampling.data.readers.images import Image
from supersampling.data.readers.layout import CaptureClip, Layout
from supersampling.data.readers.png_images import png_size, read_png, read_png_colors
from supersampling.data.readers.units import checked_jitter, checked_motion
from supersampling.errors import UserError

SPLITS = {"TrainSet": "train", "TestSet": "test"}
RESOLUTIONS = {2: ("540p", "1"), 3: ("360p", "1.58"), 4: ("270p", "2")}
"""Folder and mip bias (negated) of each scale."""
TARGET = ("1080p", "Enhanced")
CAMERA = "CameraData"
DIGIT = 255.0


def modality(kind: str, scale: int) -> str:
    """Return the folder name of a jittered, mip-biased modality; ``kind``: empty (colour), ``Depth`` or
    ``MotionVectors``."""
    return f"{kind}MipBiasMinus{RESOLUTIONS[scale][1]}Jittered"


def check_scale(scale: int) -> None:
    """Raise `UserError` for a scale that QRISP does not have."""
    if scale not in RESOLUTIONS:
        raise UserError(f"QRISP has no inputs for a scale of {scale}: use one of {', '.join(map(str, RESOLUTIONS))}.")


def decode_depth(rgba: NDArray[np.uint8]) -> Image:
    """Return depth by annex A, equation 4: ``R/255 + G/255^2 + B/255^3 + A/255^4``, at most 1; ``(h, w, 4)`` to ``(h,
    w, 1)``.

    The steps of 2.4e-10 are finer than float32 above 0.004, so that a float32 depth is restored exactly there.
    """
    depth = rgba.astype(np.float64) @ (DIGIT ** -np.arange(1.0, 5.0))
    return np.minimum(depth, 1.0).astype(np.float32)[..., None]


def encode_depth(depth: Image) -> NDArray[np.uint8]:
    """Return the inverse of `decode_depth`: ``(h, w, 1)`` in [0, 1] to ``(h, w, 4)``."""
    steps = np.round(np.clip(depth[..., 0].astype(np.float64), 0.0, 1.0) * DIGIT**4).astype(np.int64)
    base = int(DIGIT)
    # 255 for a depth of 1, where the other digits are 0.
    red = steps // base**3
    digits = [steps // base**k % base for k in (2, 1, 0)]
    return np.stack([red, *digits], axis=-1).astype(np.uint8)


class Qrisp(Layout):
    """The layout of the module's docstring. Motion and jitter: annex A.2.

    The paper says "vertical first": EXR files list their channels by name, so that G precedes R. For the order R, G
    this is ``-xy``, because Unity's motion is current minus previous with y up; a public inspection of the data
    measured the same. The camera is shifted by the jitter, with y up.
    """

    motion = Convention("-xy")
    jitter = Convention("x-y")
    buffers = frozenset({"color", "depth", "motion", "jitter", "target"})

    def notes(self) -> dict[str, str]:
        return {
            "attribution": "QRISP data set, Qualcomm (Mercier et al. 2023); see its licence",
            "tonemap": "the game's own, unknown",
        }

    def clips(self) -> list[CaptureClip]:
        check_scale(self.scale)
        clips: list[CaptureClip] = []
        for set_name, split in SPLITS.items():
            for scene in self.root.folders(set_name):
                low = (set_name, scene, RESOLUTIONS[self.scale][0])
                if not self.root.folders(*low, modality("", self.scale)):
                    print(f"{'/'.join(low)} has no {modality('', self.scale)}: {scene} is left out.")
                    continue
                kinds = [(*low, modality(kind, self.scale)) for kind in ("", "Depth", "MotionVectors")]
                segments = {s for kind in (*kinds, (set_name, scene, *TARGET)) for s in self.root.folders(*kind)}
                clips += [QrispClip(self, set_name, split, scene, segment) for segment in sorted(segments)]
        if not clips:
            raise UserError(
                f"{self.root.path} has no clips in the layout <TrainSet or "
                f"TestSet>/<Scene>/{RESOLUTIONS[self.scale][0]}/"
                f"{modality('', self.scale)}/<segment>: set path to the folder that holds TrainSet or TestSet."
            )
        return clips


class QrispClip(CaptureClip):
    """The clip of one segment."""

    def __init__(self, layout: Qrisp, set_name: str, split: str, scene: str, segment: str) -> None:
        self._conventions, scale = layout.conventions, layout.scale
        base = Path(set_name, scene)
        low, root = base / RESOLUTIONS[scale][0], layout.root
        self._streams = {
            "color": root.frames(low / modality("", scale) / segment, ".png"),
            "depth": root.frames(low / modality("Depth", scale) / segment, ".png"),
            "motion": root.frames(low / modality("MotionVectors", scale) / segment, ".exr"),
            "target": root.frames(base.joinpath(*TARGET) / segment, ".png"),
        }
        self._numbers = frame_numbers(self._streams)
        self._jitters = Jitters(root, low / CAMERA, segment, self._numbers)
        size = png_size(self._streams["target"][self._numbers[0]])
        super().__init__(f"qrisp/{scene}", split, f"{base}/{segment}", size)
        if size[0] % scale or size[1] % scale:
            raise UserError(
                f"{self._streams['target'].folder} has images of {size[0]}x{size[1]} pixels, not a multiple of the "
                "scale "
                f"{scale}: correct task.scale."
            )
        self._low_size = (size[0] // scale, size[1] // scale)

    @property
    def frames(self) -> int:
        return len(self._numbers)

    def files(self) -> Iterable[Path]:
        for stream in self._streams.values():
            yield from (stream[k] for k in self._numbers)
        yield from self._jitters.files()

    def read(self, t: int, names: frozenset[str]) -> dict[str, Image]:
        number = self._numbers[t]
        paths = {name: stream[number] for name, stream in self._streams.items()}
        out: dict[str, Image] = {}
        for name, size in (("color", self._low_size), ("target", self.size)):
            if name in names:
                out[name] = read_png_colors(paths[name], size)
        if "depth" in names:
            depth = decode_depth(read_png(paths["depth"], self._low_size, 4))
            out["depth"] = 1.0 - depth if self._conventions.reversed_depth else depth
        if "motion" in names:
            stored = read_exr(paths["motion"], self._low_size, ("RG", "XY"))
            out["motion"] = checked_motion(self._conventions.motion.decode(stored), paths["motion"])
        if "jitter" in names:
            stored, path = self._jitters.read(number)
            out["jitter"] = checked_jitter(self._conventions.jitter.decode(stored), path)
        return out


def baseline_images(path: Path, scene: str) -> dict[str, dict[str, Frames]]:
    """Return the images of other methods that QRISP has for a scene (such as ``Seaport``), by method and segment.

    A method is the name of a folder in ``1080p`` that begins with DLSS or FSR.

    Raises:
        UserError: the scene is missing or has no such images.
    """
    root, methods = Root(path), dict[str, dict[str, Frames]]()
    for set_name in SPLITS:
        for method in root.folders(set_name, scene, TARGET[0]):
            if method.upper().startswith(("DLSS", "FSR")):
                base = Path(set_name, scene, TARGET[0], method)
                methods[method] = {s: root.frames(base / s, ".png") for s in root.folders(str(base))}
    if not methods:
        raise UserError(
            f"{path} has no images of DLSS or FSR for the scene {scene}: unpack <set>/{scene}/1080p/DLSS* or FSR*."
        )
    return methods
