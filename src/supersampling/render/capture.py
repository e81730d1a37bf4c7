"""Renders the clips of a data set file: resumable clip by clip, and the same to the byte however often it was interrupted."""

import hashlib
import json
import shutil
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from filelock import FileLock
from numpy.typing import NDArray
from tqdm import tqdm

from supersampling import __version__
from supersampling.data.spec import CaptureSpec
from supersampling.data.store import ClipArrays, Store, quantise, write_file
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.render.check import check_spec
from supersampling.render.content import load_scene
from supersampling.render.jitter import jitter_sequence, mip_bias, target_mip_bias
from supersampling.render.paths import FRAMES_PER_SECOND
from supersampling.render.renderer import TONEMAP, Renderer
from supersampling.render.scene import Scene
from supersampling.render.selection import Take, choose

_LOW = frozenset(name for name, b in BUFFERS.items() if b.resolution == "low")


def render_clip(renderer: Renderer, spec: CaptureSpec, take: Take, step: Callable[[], object]) -> ClipArrays:
    """All stored buffers of one clip, quantised, ``(T, ...)``; ``step()`` is called after each frame."""
    sequence = jitter_sequence(spec.jitter, spec.scale)
    bias, target_bias = mip_bias(spec.mip_bias, spec.scale), target_mip_bias(spec.mip_bias)
    frames: dict[str, list[NDArray]] = {name: [] for name in (*_LOW, "jitter", "target")}
    for t in range(spec.frames):
        shot = take.shot(t)
        jitter = sequence[(take.jitter_phase + t) % len(sequence)]
        low = renderer.low(shot, spec.scale, (float(jitter[0]), float(jitter[1])), bias, _LOW)
        for name in _LOW:
            frames[name].append(quantise(name, low[name]))
        frames["jitter"].append(jitter)
        if t >= spec.frames - spec.targets:
            frames["target"].append(quantise("target", renderer.target(shot, spec.samples, target_bias)))
        step()
    return {name: np.stack(values) for name, values in frames.items()}


def _save_part(path: Path, clip: ClipArrays) -> None:
    beside = path.with_suffix(".tmp")
    try:
        with beside.open("wb") as file:
            np.savez(file, **clip)  # type: ignore[arg-type]
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise UserError(
            f"Cannot write {path}: {error.strerror or error}. Free some space, then run again: finished clips "
            "are kept."
        ) from error


def _load_part(path: Path) -> ClipArrays:
    with np.load(path, allow_pickle=False) as part:
        return {name: part[name] for name in part.files}


def render_file(spec: CaptureSpec, folder: Path, scene: Scene | None = None) -> Path:
    """Render what is missing of one data set file and return its path; a finished file is only opened and checked.

    Clips are kept one by one in a folder beside the file until all are there; then the file is written and renamed in
    one go and the folder removed. A lock keeps two processes from rendering the same file.

    Raises:
        UserError: a wrong specification, no such scene, no OpenGL, or no space.
    """
    check_spec(spec)
    path = folder / spec.file_name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"Cannot make the data folder {folder}: {error.strerror}. Set paths.data to another one."
        ) from error
    with FileLock(folder / f".{spec.file_name}.lock"):
        if path.exists():
            store = Store(path)
            held, fresh = store.spec, store.spec == spec
            store.close()
            if not fresh:
                raise UserError(
                    f"{path} holds {held.to_json()}, which is not what its name says: remove the file."
                )
            return path
        parts = folder / f"{spec.file_name}.clips"
        renderer_name, attribution = _render_parts(spec, parts, scene)
        clips = [_load_part(parts / f"{k:04d}.npz") for k in range(spec.clips)]
        write_file(path, spec, clips, _attributes(spec, clips, renderer_name, attribution))
        shutil.rmtree(parts)
    return path


def _render_parts(spec: CaptureSpec, parts: Path, scene: Scene | None) -> tuple[str, str]:
    """Render the clips that are not in ``parts`` yet; returns the renderer's name and the scene's attribution."""
    scene = scene or load_scene(spec.scene)
    parts.mkdir(exist_ok=True)
    missing = [k for k in range(spec.clips) if not (parts / f"{k:04d}.npz").exists()]
    takes = choose(scene, spec, missing)
    with Renderer(scene) as renderer:
        _same_renderer(parts, renderer.gl_renderer)
        label = f"render {spec.scene} {spec.split}"
        done = (spec.clips - len(missing)) * spec.frames
        with tqdm(
            total=spec.clips * spec.frames, initial=done, desc=label, unit="frame", mininterval=1.0
        ) as bar:
            started = time.monotonic()
            for clip in missing:
                _save_part(parts / f"{clip:04d}.npz", render_clip(renderer, spec, takes[clip], bar.update))
                seconds = (time.monotonic() - started) / max(bar.n - done, 1)
                bar.set_postfix_str(f"{seconds:.2f} s a frame")
        return renderer.gl_renderer, scene.attribution


def _same_renderer(parts: Path, name: str) -> None:
    """Refuse to finish a half-rendered file with another OpenGL renderer: they differ in low bits."""
    note = parts / "renderer.txt"
    if not note.exists():
        note.write_text(name)
    elif note.read_text() != name:
        raise UserError(
            f"{parts} was begun with the renderer {note.read_text()!r}, this one is {name!r}: remove the "
            "folder to start again."
        )


def _attributes(
    spec: CaptureSpec, clips: Iterable[ClipArrays], renderer: str, attribution: str
) -> dict[str, str]:
    digest = hashlib.sha256(spec.to_json().encode())
    for clip in clips:
        for name in sorted(clip):
            digest.update(np.ascontiguousarray(clip[name]).tobytes())
    return {
        "fingerprint": digest.hexdigest()[:16],
        "renderer": renderer,
        "software": f"supersampling {__version__}",
        "attribution": attribution,
        "tonemap": TONEMAP,
        "target_filter": f"box over {spec.samples}x{spec.samples} display-referred samples a pixel",
        "jitter_sequence": json.dumps(jitter_sequence(spec.jitter, spec.scale).tolist()),
        "low_mip_bias": repr(mip_bias(spec.mip_bias, spec.scale)),
        "target_mip_bias": repr(target_mip_bias(spec.mip_bias)),
        "frames_per_second": repr(FRAMES_PER_SECOND),
    }
