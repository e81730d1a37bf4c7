"""Rendering of many data set files by several processes, each clip by one process."""

import multiprocessing
import os
import signal
import time
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.queues import Queue
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

from tqdm import tqdm

from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.render.capture import DataFile, Studio
from supersampling.scenes.load import check_scene
from supersampling.scenes.scene import Scene

_POLL = 0.2  # seconds
_THREADS = "LP_NUM_THREADS"


@dataclass(frozen=True)
class Order:
    """Rendering order: the buffers ``names`` of ``specs`` in ``folder``; ``path`` is the file of a glTF scene."""

    specs: tuple[CaptureSpec, ...]
    folder: Path
    names: frozenset[str]
    path: Path | None = None

    def files(self) -> list[DataFile]:
        return [DataFile(spec, self.folder, self.names) for spec in self.specs]


def render_files(
    specs: Sequence[CaptureSpec],
    folder: Path,
    names: frozenset[str],
    workers: int = 1,
    *,
    path: Path | None = None,
    scene: Scene | None = None,
) -> list[Path]:
    """Render the missing parts of these data set files with ``workers`` processes, and return the files' paths.

    Clips that another running command is rendering are waited for. ``path`` is the file of a glTF scene. ``scene``
    replaces the scene that the specifications name; it cannot be sent to another process.

    Raises:
        UserError: A specification or buffer is invalid, the scene does not exist, OpenGL is missing, or the disk is
        full.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"Cannot create the data folder {folder} ({error.strerror}): set paths.data to another folder."
        ) from error
    order = Order(tuple(specs), folder, names, path)
    files = order.files()
    if scene is None:
        for name in sorted({file.spec.scene for file in files if file.missing()}):
            check_scene(name)
    while any(file.missing() for file in files):
        clips = [len(file.waiting()) for file in files]
        frames = sum(count * file.spec.frames for count, file in zip(clips, files))
        with tqdm(total=frames, desc="render", unit="frame", mininterval=1.0, delay=1.0) as bar:
            if min(workers, sum(clips)) > 1 and scene is None:
                _by_processes(order, min(workers, sum(clips)), bar)
            else:
                _in_this_process(files, Studio(scene, path), bar)
        if any(file.missing() for file in files):
            time.sleep(_POLL)  # another command is rendering the other clips
    return [file.path for file in files]


def _in_this_process(files: Sequence[DataFile], studio: Studio, bar: tqdm) -> None:
    with studio:
        for file in files:
            bar.set_description(f"render {file.spec.scene} {file.spec.split}", refresh=False)
            file.work(studio, bar.update)


def _by_processes(order: Order, workers: int, bar: tqdm) -> None:
    """Render with this process and ``workers - 1`` spawned ones: an OpenGL context does not survive a fork."""
    context = multiprocessing.get_context("spawn")
    frames, errors = context.Value("l", 0), context.Queue()
    arguments = (order, frames, errors, os.getpid())
    processes = [context.Process(target=_worker, args=arguments, daemon=True) for _ in range(workers - 1)]

    def report(finished: int = 1) -> None:
        with frames.get_lock():
            frames.value += finished
            bar.update(frames.value - bar.n)
        if not errors.empty():
            raise _exception(*errors.get())

    try:
        for process in processes:
            process.start()
        with _single_core(), Studio(path=order.path) as studio:
            for file in order.files():
                file.work(studio, report)
        while any(process.is_alive() for process in processes):
            time.sleep(_POLL)
            report(0)
        for process in processes:
            process.join()
            report(0)
            if process.exitcode != 0:
                raise RuntimeError(f"A rendering process ended with status {process.exitcode}.")
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()


@contextmanager
def _single_core() -> Iterator[None]:
    """Make Mesa's software rasteriser use only the calling thread, for contexts that are created inside."""
    before = os.environ.get(_THREADS)
    os.environ[_THREADS] = "0"
    try:
        yield
    finally:
        del os.environ[_THREADS]
        if before is not None:
            os.environ[_THREADS] = before


def _exception(by_user: bool, text: str) -> Exception:
    return UserError(text) if by_user else RuntimeError(f"A rendering process failed:\n{text}")


def _worker(order: Order, frames: "Synchronized[int]", errors: "Queue[tuple[bool, str]]", parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends this process
    warnings.simplefilter("ignore", UserWarning)  # the parent reads the same scene and issues the same warnings

    def report() -> None:
        if os.getppid() != parent:
            os._exit(1)  # the parent was killed
        with frames.get_lock():
            frames.value += 1

    try:
        with _single_core(), Studio(path=order.path) as studio:
            for file in order.files():
                file.work(studio, report)
    except UserError as error:
        errors.put((True, str(error)))
    except Exception:
        errors.put((False, traceback.format_exc()))
