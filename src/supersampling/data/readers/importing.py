"""Import of captures into data set files: frame by frame in bounded memory, resumable after a kill at any moment."""

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from tqdm import tqdm

from supersampling import __version__
from supersampling.data.clipwise import ClipwiseFile
from supersampling.data.readers.arm import Arm
from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.depth_check import check_depth
from supersampling.data.readers.files import Root
from supersampling.data.readers.jitter_check import check_jitter
from supersampling.data.readers.layout import CaptureClip, Conventions, Layout
from supersampling.data.readers.motion_check import check_motion
from supersampling.data.readers.nsrd import Nsrd
from supersampling.data.readers.pairs import select_pairs
from supersampling.data.readers.qrisp import Qrisp
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter
from supersampling.errors import UserError

LAYOUTS: dict[str, type[Layout]] = {"qrisp": Qrisp, "nsrd": Nsrd, "arm": Arm}
RECORDED = "recorded"
_POLL = 0.2  # seconds
READER_VERSION = 2
"""Increase it when the readers produce different content from the same capture."""


class Overrides(NamedTuple):
    """The conventions that the user states, which override the documentation of the layout."""

    motion: bool
    jitter: bool
    depth: bool


def import_capture(
    layout: str,
    path: Path,
    folder: Path,
    *,
    scale: int,
    convention: str | None = None,
    jitter_convention: str | None = None,
    reversed_depth: bool | None = None,
) -> list[Path]:
    """Read a capture into data set files: one per scene, split, clip length and size.

    Existing clips are kept, so that an import that was killed continues with the clip at which it stopped; several
    processes may import the same capture at once. Before a file is started, its motion, jitter and depth are checked on
    a few frames.

    Args:
        layout: ``qrisp``, ``nsrd`` or ``arm``; see the modules of these names.
        path: the capture's folder, as described in the layout's module.
        folder: the folder for the data set files.
        scale: target pixels per low-resolution pixel, on each axis.
        convention: the convention of motion files (`conventions.Convention`), such as ``-xy``; as documented if None.
        jitter_convention: the same for jitter.
        reversed_depth: whether depth files run from 1 near to 0 far; as documented if None.

    Returns:
        The data set files.

    Raises:
        UserError: the capture is incomplete, broken, or contradicts its layout, in one sentence that names the file; or
            the folder cannot be written. Finished files and clips remain.
    """
    if layout not in LAYOUTS:
        raise UserError(f"Unknown capture layout {layout}: use one of {', '.join(LAYOUTS)}.")
    kind = LAYOUTS[layout]
    conventions = Conventions(
        kind.motion if convention is None else Convention.parse(convention),
        kind.jitter if jitter_convention is None else Convention.parse(jitter_convention),
        reversed_depth,
    )
    overrides = Overrides(convention is not None, jitter_convention is not None, reversed_depth is not None)
    capture = kind(Root(path), scale, conventions)
    clips = sorted(capture.clips(), key=_group)
    paths = []
    for _, group in groupby(clips, key=_group):
        file = ImportedFile(layout, capture, list(group), folder)
        file.work(overrides)
        paths.append(file.path)
    return paths


def _group(clip: CaptureClip) -> tuple[str, str, int, tuple[int, int]]:
    return clip.scene, clip.split, clip.frames, clip.size


class ImportedFile:
    """A data set file of ``clips`` of the same scene, split, length and size."""

    def __init__(self, name: str, layout: Layout, clips: Sequence[CaptureClip], folder: Path) -> None:
        self._layout, self._clips = layout, clips
        first = clips[0]
        self.spec = CaptureSpec(
            scene=first.scene,
            split=first.split,
            clips=len(clips),
            frames=first.frames,
            targets=first.frames,
            frame=first.size,
            window=first.size,
            scale=layout.scale,
            jitter=RECORDED,
            mip_bias=RECORDED,
            samples=0,
            seed=0,
            candidates=0,
            camera=RECORDED,
            origin=f"{name}:{layout.root.name}:{_digest(layout, clips)}",
        )
        self._file = ClipwiseFile(self.spec, folder, layout.buffers)
        self.path = self._file.path

    def work(self, overrides: Overrides) -> None:
        """Check the capture, read every missing clip, wait for the clips of other processes, and join all."""
        if self._file.missing():
            self._check(overrides)
        while self._file.missing():
            frames = len(self._file.waiting()) * self.spec.frames
            with tqdm(total=frames, unit="frame", desc=self._label, delay=1.0) as bar:
                self._file.work(
                    lambda clip, writer, names: self._read(clip, writer, names, bar.update), self._attributes()
                )
            if self._file.missing():
                time.sleep(_POLL)

    @property
    def _label(self) -> str:
        return f"{self.spec.scene} {self.spec.split}"

    def _check(self, overrides: Overrides) -> None:
        conventions, pairs = self._layout.conventions, select_pairs(self._clips)
        print(check_motion(self._label, pairs, conventions.motion, overrides.motion))
        if "color" in self._layout.buffers:
            print(check_jitter(self._label, pairs, conventions.jitter, overrides.jitter))
        print(check_depth(self._label, pairs, overrides.depth))

    def _read(self, clip: int, writer: ClipWriter, names: frozenset[str], step: Callable[[], object]) -> None:
        for t in range(self.spec.frames):
            for name, image in sorted(self._clips[clip].read(t, names).items()):
                writer.add(name, image)
            step()

    def _attributes(self) -> dict[str, str]:
        conventions = self._layout.conventions
        return {
            "software": f"supersampling {__version__}",
            "renderer": f"capture {self.spec.origin}",
            "motion_convention": conventions.motion.name,
            "jitter_convention": conventions.jitter.name,
            "reversed_depth": {None: "as documented", True: "yes", False: "no"}[conventions.reversed_depth],
            "clips": json.dumps([clip.label for clip in self._clips]),
        } | self._layout.notes()


def _digest(layout: Layout, clips: Sequence[CaptureClip]) -> str:
    """Return 16 hex digits of the files and their interpretation: relative names, sizes, conventions."""
    files = [(str(f.relative_to(layout.root.path)), f.stat().st_size) for clip in clips for f in clip.files()]
    conventions = layout.conventions
    names = [conventions.motion.name, conventions.jitter.name]
    content = [READER_VERSION, *names, conventions.reversed_depth, sorted(files)]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]
