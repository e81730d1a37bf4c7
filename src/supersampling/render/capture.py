"""Rendering of the clips of data set files.

Only the requested buffers are rendered, and rendering can be resumed. The file is byte-identical regardless of
interruptions and of the number of processes.
"""

import json
from collections.abc import Callable
from pathlib import Path

from supersampling import __version__
from supersampling.data.clipwise import ClipwiseFile
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.render.check import check_buffers, check_spec
from supersampling.render.jitter import jitter_sequence, mip_bias, target_mip_bias
from supersampling.render.paths import FRAMES_PER_SECOND
from supersampling.render.renderer import TONEMAP, Renderer
from supersampling.render.selection import Take, select_take
from supersampling.scenes.load import load_scene
from supersampling.scenes.scene import Scene

FrameCallback = Callable[[], object]


def render_clip(
    renderer: Renderer,
    spec: CaptureSpec,
    take: Take,
    writer: ClipWriter,
    names: frozenset[str],
    on_frame: FrameCallback,
) -> None:
    """Render the buffers ``names`` of one clip into ``writer``; ``on_frame()`` is called after each frame."""
    sequence = jitter_sequence(spec.jitter, spec.scale)
    bias, target_bias = mip_bias(spec.mip_bias, spec.scale), target_mip_bias(spec.mip_bias)
    low = frozenset(n for n in names if BUFFERS[n].resolution == "low")
    high = frozenset(n for n in names if BUFFERS[n].resolution == "high")
    for t in range(spec.frames):
        shot = take.shot(t)
        jitter = sequence[(take.jitter_phase + t) % len(sequence)]
        if "jitter" in names:
            writer.add("jitter", jitter)
        if low:
            images = renderer.low(shot, spec.scale, (float(jitter[0]), float(jitter[1])), bias, low)
            for name, image in images.items():
                writer.add(name, image)
        if high and t >= spec.frames - spec.targets:
            for name, image in renderer.high(shot, spec.samples, target_bias, high).items():
                writer.add(name, image)
        on_frame()


class Studio:
    """Cache of the last scene and its renderer, for clips of any specification. A context manager.

    ``scene`` replaces every scene that specifications name; ``path`` is the file of a glTF scene.
    """

    def __init__(self, scene: Scene | None = None, path: Path | None = None) -> None:
        self._replacement, self._path = scene, path
        self._name = ""
        self.scene: Scene | None = scene
        self._renderer: Renderer | None = None

    def open(self, name: str) -> tuple[Scene, Renderer]:
        if self.scene is None or self._renderer is None or name != self._name:
            self.close()
            self.scene = self._replacement or load_scene(name, self._path)
            self._renderer, self._name = Renderer(self.scene), name
        return self.scene, self._renderer

    def close(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None

    def __enter__(self) -> "Studio":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class DataFile:
    """One data set file to render: the buffers ``names`` of ``spec`` in ``folder``.

    Several processes may work on it at once.

    Raises:
        UserError: The specification is invalid or a buffer cannot be rendered.
    """

    def __init__(self, spec: CaptureSpec, folder: Path, names: frozenset[str]) -> None:
        check_spec(spec)
        check_buffers(names)
        self.spec = spec
        self._file = ClipwiseFile(spec, folder, names)
        self.path, self.missing, self.waiting = self._file.path, self._file.missing, self._file.waiting

    def work(self, studio: Studio, on_frame: FrameCallback) -> None:
        """Render every missing clip that no other process is rendering, then join the clips if none is missing."""

        def write(clip: int, writer: ClipWriter, names: frozenset[str]) -> None:
            scene, renderer = studio.open(self.spec.scene)
            self._check_renderer(renderer.gl_renderer)
            render_clip(renderer, self.spec, select_take(renderer, self.spec, clip), writer, names, on_frame)
            writer.note(renderer=renderer.gl_renderer, attribution=scene.attribution)
            writer.note(near=repr(scene.near), far=repr(scene.far))

        self._file.work(write, _attributes(self.spec))

    def _check_renderer(self, name: str) -> None:
        """Raise `UserError` if the file was begun with another OpenGL renderer: renderers differ in low bits."""
        stored = self._file.begun_with("renderer")
        if stored not in (None, name):
            raise UserError(
                f"{self.path} was begun with {stored}, but this is {name}: go on with that renderer, or set paths.data "
                "to another folder."
            )


def _attributes(spec: CaptureSpec) -> dict[str, str]:
    return {
        "software": f"supersampling {__version__}",
        "tonemap": TONEMAP,
        "target_filter": f"box over {spec.samples}x{spec.samples} samples a pixel; target of display-referred ones",
        "jitter_sequence": json.dumps(jitter_sequence(spec.jitter, spec.scale).tolist()),
        "low_mip_bias": repr(mip_bias(spec.mip_bias, spec.scale)),
        "target_mip_bias": repr(target_mip_bias(spec.mip_bias)),
        "frames_per_second": repr(FRAMES_PER_SECOND),
    }
