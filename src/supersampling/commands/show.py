"""The command ``show.py``."""

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
    """Write a sheet and a video of one clip of each requested file, and print their paths.

    Raises:
        UserError: a split, buffer, file, clip or frame does not exist, a setting is out of range, or the folder cannot
            be written.
    """
    names = _buffers(cfg)
    _check(cfg)
    for path in _files(cfg, names):
        file = DatasetFile(path)
        try:
            for output in _show_file(cfg, file, names):
                print(output)
        finally:
            file.close()


def _check(cfg: DictConfig) -> None:
    for key in ("width", "video_width", "columns"):
        if not isinstance(cfg[key], int) or cfg[key] < 1:
            raise UserError(f"Invalid {key}={cfg[key]}: use an integer of at least 1.")
    for key in ("clip", "frame"):
        if not isinstance(cfg[key], int) and (key, cfg[key]) != ("frame", None):
            raise UserError(f"Invalid {key}={cfg[key]}: use an integer of at least 0.")
    if cfg.video is not None:
        check_format(cfg.video)
    if cfg.fps is not None and (not isinstance(cfg.fps, (int, float)) or cfg.fps <= 0):
        raise UserError(f"Invalid fps={cfg.fps}: use a positive number, or null for the frame rate of the data set.")


def _buffers(cfg: DictConfig) -> frozenset[str]:
    requested = [cfg.buffers] if isinstance(cfg.buffers, str) else cfg.buffers
    names = frozenset(BUFFERS if cfg.buffers == "all" else requested)
    unknown = sorted(names - BUFFERS.keys())
    if unknown:
        raise UserError(f"Unknown buffer {unknown[0]}: use some of {', '.join(sorted(BUFFERS))}, or all.")
    return names


def _files(cfg: DictConfig, names: frozenset[str]) -> list[Path]:
    if cfg.file is not None:
        return [Path(cfg.file)]
    if cfg.split not in SPLITS:
        raise UserError(f"Invalid split={cfg.split}: use one of {', '.join(SPLITS)}.")
    # Imported here because it takes seconds, and a named file does not need it.
    from supersampling.data.module import DataSource, Files

    source: DataSource = instantiate(cfg.data)
    if cfg.buffers == "all" and isinstance(source, Files):
        # All buffers of the user's files.
        names = frozenset()
    return source.files([cfg.split], names)[cfg.split]


def _show_file(cfg: DictConfig, file: DatasetFile, names: frozenset[str]) -> Iterator[Path]:
    missing = sorted(names - file.buffers) if cfg.buffers != "all" else []
    if missing:
        raise UserError(f"{file.path} has no {missing[0]}: use some of {', '.join(sorted(file.buffers))}.")
    clip = ClipView(file, cfg.clip, names)
    frame = clip.resolve_frame(cfg.frame)
    sheet_size, video_size = (display_size(clip.size, file.spec.scale, cfg[key]) for key in ("width", "video_width"))
    base = f"{file.path.stem}_clip{clip.index}"
    image = Image.fromarray(sheet(clip, frame, sheet_size, cfg.columns))
    yield _save(Path(cfg.out) / f"{base}_frame{frame}.png", lambda path: image.save(path, optimize=True))
    if cfg.video is not None:
        film = list(video_frames(clip, frame, video_size, title(clip)))
        rate = cfg.fps or frame_rate(file)
        yield _save(Path(cfg.out) / f"{base}.{cfg.video}", lambda path: write_video(path, film, rate))


def _save(path: Path, write: Callable[[Path], None]) -> Path:
    """Write a temporary file and rename it to ``path``, so that no partial file remains."""
    temporary = path.with_name(f".{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(temporary)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(f"Cannot write {path} ({error.strerror or error}): set out to another folder.") from error
    return path


def title(clip: ClipView) -> str:
    spec = clip.file.spec
    return f"{spec.scene}, {spec.split}, clip {clip.index}"


def sheet(clip: ClipView, frame: int, size: tuple[int, int], columns: int) -> Picture:
    """Return all panels of a frame as one picture."""
    return compose(f"{title(clip)}, frame {frame}", sections(clip, frame, size), size, columns)


def frame_rate(file: DatasetFile) -> float:
    """Return the frames per second according to the file, else 30."""
    return float(file.attributes.get("frames_per_second", 30.0))
