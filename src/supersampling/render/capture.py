"""Renders the clips of data set files: only the buffers that are asked for, resumable, and the same to the byte however often
it was interrupted and by however many processes it was done."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
from filelock import FileLock, Timeout

from supersampling import __version__
from supersampling.data.spec import CaptureSpec
from supersampling.data.store import Store
from supersampling.data.writer import ClipWriter, buffers_in, join_clips
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.render.check import check_buffers, check_spec
from supersampling.render.content import load_scene
from supersampling.render.jitter import jitter_sequence, mip_bias, target_mip_bias
from supersampling.render.paths import FRAMES_PER_SECOND
from supersampling.render.renderer import TONEMAP, Renderer
from supersampling.render.scene import Scene
from supersampling.render.selection import Take, choose

Step = Callable[[], object]


def render_clip(
    renderer: Renderer, spec: CaptureSpec, take: Take, writer: ClipWriter, names: frozenset[str], step: Step
) -> None:
    """Render the buffers ``names`` of one clip into ``writer``; ``step()`` is called after each frame."""
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
        step()


def lengths(spec: CaptureSpec, names: frozenset[str]) -> dict[str, int]:
    """How many frames of a clip have each of these buffers."""
    return {n: spec.targets if BUFFERS[n].resolution == "high" else spec.frames for n in sorted(names)}


class Studio:
    """Renders clips of any specification; the last scene and its OpenGL context are kept. A context manager.

    ``scene`` stands for all that specifications name; ``path`` is the file of a glTF scene.
    """

    def __init__(self, scene: Scene | None = None, path: Path | None = None) -> None:
        self._given, self._path = scene, path
        self._name = ""
        self.scene: Scene | None = scene
        self._renderer: Renderer | None = None

    def open(self, name: str) -> tuple[Scene, Renderer]:
        if self.scene is None or self._renderer is None or name != self._name:
            self.close()
            self.scene = self._given or load_scene(name, self._path)
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
    """One data set file to be made: ``names`` of ``spec`` under ``folder``. Several processes may work on it at once.

    Clips are kept one by one in a folder beside the file until all are there. A clip under way is claimed by a lock, which
    the system lets go when its process dies.

    Raises:
        UserError: a wrong specification or a buffer that cannot be rendered.
    """

    def __init__(self, spec: CaptureSpec, folder: Path, names: frozenset[str]) -> None:
        check_spec(spec)
        check_buffers(names)
        self.spec, self.path, self._names = spec, folder / spec.file_name, names
        self._parts = folder / f"{spec.file_name}.clips"
        self._lock = folder / f".{spec.file_name}.lock"

    def missing(self) -> frozenset[str]:
        """The buffers that the file lacks.

        Raises:
            UserError: the file is truncated, or holds something else than its name says.
        """
        if not self.path.exists():
            return self._names
        store = Store(self.path)
        held, buffers = store.spec, store.buffers
        store.close()
        if held != self.spec:
            raise UserError(
                f"{self.path} holds {held.to_json()}, which is not what its name says: remove the file."
            )
        return self._names - buffers

    def _part(self, clip: int) -> Path:
        return self._parts / f"{clip:04d}.h5"

    def waiting(self) -> list[int]:
        """The clips that still have to be rendered."""
        missing = self.missing()
        return (
            [k for k in range(self.spec.clips) if not missing <= buffers_in(self._part(k))] if missing else []
        )

    def work(self, studio: Studio, step: Step) -> None:
        """Render every clip that is missing and that no other process is at, then join them if all are there."""
        if not self.missing():
            self._tidy()
            return
        self._parts.mkdir(parents=True, exist_ok=True)
        for clip in self.waiting():
            self._render(clip, studio, step)
        if not self.waiting():
            self._join()

    def _render(self, clip: int, studio: Studio, step: Step) -> None:
        part = self._part(clip)
        try:
            with FileLock(part.with_suffix(".lock"), timeout=0):
                missing = self.missing()
                if missing <= buffers_in(part):  # done by another process in the meantime
                    return
                scene, renderer = studio.open(self.spec.scene)
                self._check_renderer(renderer.gl_renderer)
                take = choose(renderer, self.spec, clip)
                with ClipWriter(part, lengths(self.spec, missing)) as writer:
                    render_clip(renderer, self.spec, take, writer, missing, step)
                    writer.note(renderer=renderer.gl_renderer, attribution=scene.attribution)
        except Timeout:
            return

    def _check_renderer(self, name: str) -> None:
        """Refuse to go on with another OpenGL renderer: they differ in low bits."""
        for path in (self.path, *sorted(self._parts.glob("*.h5"))[:1]):
            if not path.exists():
                continue
            with h5py.File(path, "r") as file:
                began = str(file.attrs["renderer"])
            if began != name:
                raise UserError(
                    f"{path} was made with the renderer {began!r}, this one is {name!r}: remove it to start again."
                )

    def _join(self) -> None:
        with FileLock(self._lock):
            missing = self.missing()
            if missing:
                parts = [self._part(k) for k in range(self.spec.clips)]
                with h5py.File(parts[0], "r") as first:
                    made = {key: str(first.attrs[key]) for key in ("renderer", "attribution")}
                join_clips(self.path, self.spec, parts, missing, made | _attributes(self.spec))
        self._tidy()

    def _tidy(self) -> None:
        """Remove the clips of a finished file."""
        if self._parts.exists():
            shutil.rmtree(self._parts, ignore_errors=True)


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
