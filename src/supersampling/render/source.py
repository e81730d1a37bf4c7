"""Data sets that are rendered on request; only missing clips and buffers are rendered."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict, Unpack

from supersampling.data.module import DataSource
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.render.check import check_spec


@dataclass(frozen=True, kw_only=True)
class SplitOptions:
    """Options of one split.

    ``targets`` is how many of a clip's last frames have a target (None for all), ``window`` the rendered ``[width,
    height]`` (None for whole frames), ``samples`` the side of the target's sample grid, and ``candidates`` the number
    of takes that each clip is selected from.
    """

    clips: int
    frames: int
    targets: int | None
    window: Sequence[int] | None
    samples: int
    candidates: int


class SharedOptions(TypedDict):
    """Options that all splits share: fields of `CaptureSpec`."""

    scale: int
    jitter: str
    mip_bias: str
    seed: int
    camera: str


class Rendered(DataSource):
    """Rendered data sets: one file per scene and split in ``folder``; ``path`` is the file of the scene ``gltf``.

    ``frame`` is the whole target frame ``[width, height]``; ``train``, ``val`` and ``test`` are `SplitOptions`.
    ``workers`` is the number of rendering processes, which does not change the result.
    """

    def __init__(
        self,
        *,
        scenes: str | Sequence[str],
        path: str | None,
        folder: str,
        workers: int,
        frame: Sequence[int],
        train: Mapping[str, Any],
        val: Mapping[str, Any],
        test: Mapping[str, Any],
        **shared: Unpack[SharedOptions],
    ) -> None:
        self._path = None if path is None else Path(path)
        self._origins = _origins([scenes] if isinstance(scenes, str) else scenes, self._path)
        self._folder = Path(folder)
        self._frame = (int(frame[0]), int(frame[1]))
        self._shared = shared
        self._workers = workers
        splits = {"train": train, "val": val, "test": test}
        self._splits = {split: SplitOptions(**options) for split, options in splits.items()}
        for split in self._splits:
            for spec in self.specs(split):
                check_spec(spec)

    def specs(self, split: str) -> list[CaptureSpec]:
        options = self._splits[split]
        width, height = options.window or self._frame
        return [
            CaptureSpec(
                scene=scene,
                split=split,
                origin=origin,
                clips=options.clips,
                frames=options.frames,
                targets=options.targets or options.frames,
                frame=self._frame,
                window=(int(width), int(height)),
                samples=options.samples,
                candidates=options.candidates,
                **self._shared,
            )
            for scene, origin in self._origins.items()
        ]

    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]:
        from supersampling.render.pool import render_files

        specs = {split: self.specs(split) for split in splits}
        requested = [spec for split in splits for spec in specs[split]]
        render_files(requested, self._folder, buffers, self._workers, path=self._path)
        return {split: [self._folder / spec.file_name for spec in specs[split]] for split in splits}


def _origins(scenes: Sequence[str], path: Path | None) -> dict[str, str]:
    """Return the origin of each scene by its name.

    ``gltf`` becomes ``gltf/<stem of path>``, and its origin the fingerprint of all files that it reads; the origin of
    any other scene is empty.

    Raises:
        UserError: There is no scene, or ``gltf`` without a path.
    """
    if not scenes:
        raise UserError("Empty scene=[]: use for example scene=[atrium,foundry] or scene=stk/zengarden.")
    if "gltf" not in scenes:
        return dict.fromkeys(scenes, "")
    if path is None:
        raise UserError("Missing path for scene=gltf: add path=FILE.gltf or path=FILE.glb.")
    from supersampling.scenes.gltf import fingerprint

    name = f"gltf/{path.stem}"
    names = dict.fromkeys((name if scene == "gltf" else scene for scene in scenes), "")
    return names | {name: f"gltf:{fingerprint(path)}"}
