"""Existing frames as a method: the output of another program, or the targets of a data set."""

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import final

import torch
from torch import Tensor

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.readers.exr import read_opaque_exr
from supersampling.data.readers.png_images import read_display_png
from supersampling.data.readers.qrisp import baseline_images
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.display import radiance_to_display

Clips = Sequence[Sequence[Path]]
"""One file per frame of every clip, in the order of scoring."""


class Recording(ABC):
    """Base class of the sources of frames."""

    @abstractmethod
    def read(self, clip: int, frame: int, size: tuple[int, int]) -> Tensor:
        """Return one image ``(3, H, W)`` of ``size (W, H)``, in the colour space of the recording.

        Raises:
            UserError: the image is broken, of a different size or of a different format.
        """

    def shown(self, image: Tensor) -> Tensor:
        """Return the display-referred colours in [0, 1] of an image."""
        return image

    def radiance(self, image: Tensor) -> Tensor | None:
        """Return the linear radiance of an image; None if the recording has display colours only."""
        return None

    @property
    @abstractmethod
    def fingerprint(self) -> str:
        """Return 16 hex digits of the content."""


class _Images(Recording):
    def __init__(self, clips: Clips) -> None:
        self._clips = [list(clip) for clip in clips]

    @property
    def fingerprint(self) -> str:
        digest = hashlib.sha256()
        for path in (path for clip in self._clips for path in clip):
            digest.update(path.read_bytes())
        return digest.hexdigest()[:16]


@final
class DisplayImages(_Images):
    """PNG images of sRGB display colours, 8 or 16 bits; an alpha channel must be opaque."""

    def read(self, clip: int, frame: int, size: tuple[int, int]) -> Tensor:
        return torch.from_numpy(read_display_png(self._clips[clip][frame], size)).permute(2, 0, 1)


@final
class RadianceImages(_Images):
    """EXR images of linear radiance in the data set's exposure; displayed like images of the project's renderer."""

    def read(self, clip: int, frame: int, size: tuple[int, int]) -> Tensor:
        image = read_opaque_exr(self._clips[clip][frame], size)
        return torch.from_numpy(image).permute(2, 0, 1)

    def shown(self, image: Tensor) -> Tensor:
        return radiance_to_display(image)

    def radiance(self, image: Tensor) -> Tensor:
        return image


@final
class TargetImages(Recording):
    """The targets as output: the scores of a perfect method."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._clips = [(file, c) for file in map(DatasetFile, files) for c in range(file.clips)]

    def read(self, clip: int, frame: int, size: tuple[int, int]) -> Tensor:
        file, index = self._clips[clip]
        return torch.from_numpy(file.read("target", index, slice(frame, frame + 1)))[0]

    @property
    def fingerprint(self) -> str:
        return "targets"


@final
class Playback(Upsampler[int]):
    """Method whose output are the clips of a recording, in order; the state is the number of the next frame."""

    requires = frozenset({"color"})

    def __init__(self, scale: int, recording: Recording) -> None:
        super().__init__()
        self.scale = scale
        self.recording = recording
        self._clip = -1

    def forward(self, frame: Frame, state: int | None) -> tuple[Tensor, int]:
        assert frame.color is not None
        if state is None:
            self._clip, state = self._clip + 1, 0
        height, width = (self.scale * n for n in frame.color.shape[-2:])
        image = self.recording.read(self._clip, state, (width, height))
        return image[None].to(frame.color), state + 1

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return self.recording.shown(output)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        return self.recording.radiance(output)


def read_recorded_methods(capture: Path, files: Sequence[Path]) -> dict[str, Playback]:
    """Return the methods whose images a QRISP ``capture`` has for these data set files, which were imported from it.

    Raises:
        UserError: a file was not imported from QRISP, or images of a method are missing for one of its clips.
    """
    images: dict[str, list[list[Path]]] = {}
    scales = set()
    for path in files:
        file = DatasetFile(path)
        spec, segments = file.spec, [str(c) for c in json.loads(file.attributes.get("clips", "[]"))]
        file.close()
        scales.add(spec.scale)
        if not spec.scene.startswith("qrisp/"):
            raise UserError(
                f"{path} was not imported from a QRISP capture: import it with import_capture.py layout=qrisp."
            )
        for method, streams in baseline_images(capture, spec.scene.removeprefix("qrisp/")).items():
            for label in segments:
                segment = label.rsplit("/", 1)[-1]
                frames = streams[segment].files if segment in streams else {}
                if len(frames) != spec.frames:
                    raise UserError(
                        f"{capture} has {len(frames)} images of {method} for the {spec.frames} frames of segment "
                        f"{segment} "
                        f"of {spec.scene}: unpack them all."
                    )
                images.setdefault(method, []).append([frames[number] for number in sorted(frames)])
    return {method: Playback(max(scales), DisplayImages(clips)) for method, clips in images.items()}
