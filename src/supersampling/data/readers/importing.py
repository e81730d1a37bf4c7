"""Imports captures into data set files: frame by frame in bounded memory, clip by clip, resumable after a kill at any moment."""

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
READER_VERSION = 1
"""To be raised when the readers make other content of the same capture."""


class Overrides(NamedTuple):
    """What the user told, rather than the layout's documentation."""

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
    """Read a capture into data set files: one a scene, split, clip length and size.

    What is there already is kept, so that an import which was killed goes on with the clip that it was at; several processes
    may import the same capture at once. Before a file is begun, its motion, jitter and depth are checked on a few frames.

    Args:
        layout: ``qrisp``, ``nsrd`` or ``arm``; see the modules of these names.
        path: the capture's folder, as the layout's module says.
        folder: where the files go.
        scale: target pixels a low-resolution pixel.
        convention: what motion files hold (`conventions.Convention`), such as ``-xy``; as documented if None.
        jitter_convention: the same for jitter.
        reversed_depth: whether depth files run from 1 near to 0 far; as documented if None.

    Returns:
        the files.

    Raises:
        UserError: the capture is incomplete, broken, or does not mean what its layout says, in one sentence that names the file;
            the folder cannot be written. Finished files and clips stay.
    """
    if layout not in LAYOUTS:
        raise UserError(f"There is no capture layout {layout!r}: use one of {', '.join(LAYOUTS)}.")
    kind = LAYOUTS[layout]
    conventions = Conventions(
        kind.motion if convention is None else Convention.parse(convention),
        kind.jitter if jitter_convention is None else Convention.parse(jitter_convention),
        reversed_depth,
    )
    asked = Overrides(convention is not None, jitter_convention is not None, reversed_depth is not None)
    capture = kind(Root(path), scale, conventions)
    clips = sorted(capture.clips(), key=_group)
    made = []
    for _, group in groupby(clips, key=_group):
        file = ImportedFile(layout, capture, list(group), folder)
        file.work(asked)
        made.append(file.path)
    return made


def _group(clip: CaptureClip) -> tuple[str, str, int, tuple[int, int]]:
    return clip.scene, clip.split, clip.frames, clip.size


class ImportedFile:
    """One data set file to be made of ``clips`` of the same scene, split, length and size."""

    def __init__(self, name: str, layout: Layout, clips: Sequence[CaptureClip], folder: Path) -> None:
        self._layout, self._clips = layout, clips
        first = clips[0]
        self.spec = CaptureSpec(
            scene=first.scene, split=first.split, clips=len(clips), frames=first.frames, targets=first.frames,
            frame=first.size, window=first.size, scale=layout.scale, jitter=RECORDED, mip_bias=RECORDED, samples=0, seed=0,
            candidates=0, camera=RECORDED, origin=f"{name}:{layout.root.name}:{_digest(layout, clips)}",
        )  # fmt: skip
        self._file = ClipwiseFile(self.spec, folder, layout.buffers)
        self.path = self._file.path

    def work(self, asked: Overrides) -> None:
        """Check the capture, read every clip that is missing, and join them; clips that other processes are at are waited for."""
        if self._file.missing():
            self._check(asked)
        while self._file.missing():
            frames = len(self._file.waiting()) * self.spec.frames
            where = f"{self.spec.scene} {self.spec.split}"
            with tqdm(total=frames, unit="frame", desc=where, delay=1.0) as bar:
                self._file.work(
                    lambda clip, writer, names: self._read(clip, writer, names, bar.update),
                    self._attributes(),
                )
            if self._file.missing():
                time.sleep(_POLL)

    def _check(self, asked: Overrides) -> None:
        where, conventions = f"{self.spec.scene} {self.spec.split}", self._layout.conventions
        pairs = select_pairs(self._clips)
        print(check_motion(where, pairs, conventions.motion, asked.motion))
        if "color" in self._layout.buffers:
            print(check_jitter(where, pairs, conventions.jitter, asked.jitter))
        print(check_depth(where, pairs, asked.depth))

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
    """16 hex digits of what is read and how: relative file names, sizes, conventions."""
    files = [(str(f.relative_to(layout.root.path)), f.stat().st_size) for clip in clips for f in clip.files()]
    conventions = layout.conventions
    content = [
        READER_VERSION, conventions.motion.name, conventions.jitter.name, conventions.reversed_depth, sorted(files),
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]
