"""Images that another program upscaled, as a method: QRISP ships those of DLSS and FSR for its test scenes."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import final

import torch
from torch import Tensor

from supersampling.data.readers.images import read_png
from supersampling.data.readers.qrisp import baseline_images
from supersampling.data.store import Store
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler


@final
class Playback(Upsampler[int]):
    """Shows the recorded images of one clip after another, in the order in which clips are scored.

    ``clips`` hold an 8-bit RGB PNG of the target's size for every frame. The state is the number of the next frame.

    Raises:
        UserError: an image is broken or of another size, at the frame that it belongs to.
    """

    requires = frozenset({"color"})

    def __init__(self, scale: int, clips: Sequence[Sequence[Path]]) -> None:
        super().__init__()
        self.scale = scale
        self._clips = [list(clip) for clip in clips]
        self._clip = -1

    def forward(self, frame: Frame, state: int | None) -> tuple[Tensor, int]:
        assert frame.color is not None
        if state is None:
            self._clip, state = self._clip + 1, 0
        height, width = (self.scale * n for n in frame.color.shape[-2:])
        image = read_png(self._clips[self._clip][state], (width, height), 3)
        return torch.from_numpy(image.copy()).permute(2, 0, 1)[None].to(frame.color) / 255.0, state + 1

    @property
    def fingerprint(self) -> str:
        """16 hex digits of the images' content."""
        digest = hashlib.sha256()
        for clip in self._clips:
            for path in clip:
                digest.update(path.read_bytes())
        return digest.hexdigest()[:16]


def recorded_methods(capture: Path, files: Sequence[Path]) -> dict[str, Playback]:
    """The methods whose images a QRISP ``capture`` ships for these data set files, which were imported from it.

    Raises:
        UserError: a file was not imported from QRISP, or images of a method are missing for one of its clips.
    """
    images: dict[str, list[list[Path]]] = {}
    scales = set()
    for path in files:
        store = Store(path)
        spec, segments = store.spec, [str(c) for c in json.loads(store.attributes.get("clips", "[]"))]
        store.close()
        scales.add(spec.scale)
        if not spec.scene.startswith("qrisp/"):
            raise UserError(
                f"{path} was not imported from a QRISP capture: render.py import=qrisp makes such files."
            )
        for method, found in baseline_images(capture, spec.scene.removeprefix("qrisp/")).items():
            for label in segments:
                segment = label.rsplit("/", 1)[-1]
                frames = found[segment].files if segment in found else {}
                if len(frames) != spec.frames:
                    raise UserError(
                        f"{capture} has {len(frames)} images of {method} for the {spec.frames} frames of segment {segment} "
                        f"of {spec.scene}: unpack them all."
                    )
                images.setdefault(method, []).append([frames[number] for number in sorted(frames)])
    return {method: Playback(max(scales), clips) for method, clips in images.items()}
