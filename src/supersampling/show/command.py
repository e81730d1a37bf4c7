"""What ``show.py`` does."""

from collections.abc import Callable, Iterator
from pathlib import Path

from hydra.utils import instantiate
from omegaconf import DictConfig
from PIL import Image

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import SPLITS
from supersampling.errors import UserError
from supersampling.frames import BUFFERS
from supersampling.show.clip import ClipView
from supersampling.show.paint import Picture
from supersampling.show.panels import sections
from supersampling.show.sheet import compose, display_size
from supersampling.show.video import check_format, video_frames, write_video


def show(cfg: DictConfig) -> None:
    """Write a sheet and a video of a clip of each file that is asked for, and print their paths.

    Raises:
        UserError: no such split, buffer, file, clip or frame, a setting out of range, or a folder that cannot be written.
    """
    names = _buffers(cfg)
    _check(cfg)
    for path in _files(cfg, names):
        store = DatasetFile(path)
        try:
            for written in _show_file(cfg, store, names):
                print(written)
        finally:
            store.close()


def _check(cfg: DictConfig) -> None:
    for key in ("width", "video_width", "columns"):
        if not isinstance(cfg[key], int) or cfg[key] < 1:
            raise UserError(f"{key}={cfg[key]} is not possible: use a whole number from 1 up.")
    for key in ("clip", "frame"):
        if not isinstance(cfg[key], int) and (key, cfg[key]) != ("frame", None):
            raise UserError(f"{key}={cfg[key]} is not possible: use a whole number from 0 up.")
    if cfg.video is not None:
        check_format(cfg.video)
    if cfg.fps is not None and (not isinstance(cfg.fps, (int, float)) or cfg.fps <= 0):
        raise UserError(f"fps={cfg.fps} is not possible: use a number above 0, or null for the data set's own.")


def _buffers(cfg: DictConfig) -> frozenset[str]:
    chosen = [cfg.buffers] if isinstance(cfg.buffers, str) else cfg.buffers
    names = frozenset(BUFFERS if cfg.buffers == "all" else chosen)
    unknown = sorted(names - BUFFERS.keys())
    if unknown:
        raise UserError(f"There is no buffer {unknown[0]}: use some of {', '.join(sorted(BUFFERS))}, or all.")
    return names


def _files(cfg: DictConfig, names: frozenset[str]) -> list[Path]:
    if cfg.file is not None:
        return [Path(cfg.file)]
    if cfg.split not in SPLITS:
        raise UserError(f"split={cfg.split} is not possible: use one of {', '.join(SPLITS)}.")
    from supersampling.data.module import DataSource, Files  # takes seconds, and a file needs none of it

    source: DataSource = instantiate(cfg.data)
    if cfg.buffers == "all" and isinstance(source, Files):
        names = frozenset()  # the user's own files: all that they hold
    return source.files([cfg.split], names)[cfg.split]


def _show_file(cfg: DictConfig, store: DatasetFile, names: frozenset[str]) -> Iterator[Path]:
    missing = sorted(names - store.buffers) if cfg.buffers != "all" else []
    if missing:
        raise UserError(f"{store.path} has no {missing[0]}: it holds {', '.join(sorted(store.buffers))}.")
    clip = ClipView(store, cfg.clip, names)
    frame = clip.resolve_frame(cfg.frame)
    sheet_size, video_size = (display_size(clip.size, store.spec.scale, cfg[key]) for key in ("width", "video_width"))
    base = f"{store.path.stem}_clip{clip.index}"
    image = Image.fromarray(sheet(clip, frame, sheet_size, cfg.columns))
    yield _save(Path(cfg.out) / f"{base}_frame{frame}.png", lambda path: image.save(path, optimize=True))
    if cfg.video is not None:
        film = list(video_frames(clip, frame, video_size, title(clip)))
        rate = cfg.fps or frame_rate(store)
        yield _save(Path(cfg.out) / f"{base}.{cfg.video}", lambda path: write_video(path, film, rate))


def _save(path: Path, write: Callable[[Path], None]) -> Path:
    """Write a file beside ``path`` and rename it there, so that no half of one is left behind."""
    beside = path.with_name(f".{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(beside)
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(f"Cannot write {path}: {error.strerror or error}. Set out to another folder.") from error
    return path


def title(clip: ClipView) -> str:
    spec = clip.store.spec
    return f"{spec.scene}, {spec.split}, clip {clip.index}"


def sheet(clip: ClipView, frame: int, size: tuple[int, int], columns: int) -> Picture:
    """All panels of a frame as one picture."""
    return compose(f"{title(clip)}, frame {frame}", sections(clip, frame, size), size, columns)


def frame_rate(store: DatasetFile) -> float:
    """Frames a second: what the file says, else 30."""
    return float(store.attributes.get("frames_per_second", 30.0))
