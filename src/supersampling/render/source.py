"""Data sets that are rendered when they are asked for, and only what is missing of them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from supersampling.data.module import DataSource
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.render.check import check_spec


def installed_scenes() -> list[str]:
    """The default scenes: the built-in ones, and two SuperTuxKart tracks where their data are installed."""
    from supersampling.scenes.stk import find_data

    tracks = ["stk/zengarden", "stk/black_forest"] if find_data() else []
    return ["atrium", "foundry", *tracks]


class Rendered(DataSource):
    """One file a scene and split, in ``folder``; ``path`` is the file of the scene ``gltf``.

    ``train``, ``val`` and ``test`` hold ``clips``, ``frames``, ``targets`` (how many of a clip's last frames get one; null for
    all), ``window`` (``[width, height]``, or null for whole frames), ``samples`` (a side of the target's grid) and
    ``candidates`` (takes to choose each clip from). ``workers`` processes render, which changes no result.
    """

    def __init__(
        self, scenes: str | Sequence[str], path: str | None, folder: str, *, frame: Sequence[int], seed: int, scale: int,
        jitter: str, mip_bias: str, camera: str, workers: int,
        train: Mapping[str, Any], val: Mapping[str, Any], test: Mapping[str, Any],
    ) -> None:  # fmt: skip
        self._scenes = [scenes] if isinstance(scenes, str) else list(scenes)
        if not self._scenes:
            raise UserError("scene=[] names no scene: use for example scene=[atrium,foundry] or scene=stk/zengarden.")
        self._path = None if path is None else Path(path)
        self._origins = dict.fromkeys(self._scenes, "")
        if "gltf" in self._scenes:
            self._name_gltf()
        self._folder = Path(folder)
        self._frame = (int(frame[0]), int(frame[1]))
        self._shared: dict[str, Any] = {
            "scale": scale,
            "jitter": jitter,
            "mip_bias": mip_bias,
            "seed": seed,
            "camera": camera,
        }
        self._workers = workers
        self._splits = {"train": dict(train), "val": dict(val), "test": dict(test)}
        for split in self._splits:
            for spec in self.specs(split):
                check_spec(spec)

    def _name_gltf(self) -> None:
        """``gltf`` becomes ``gltf/<the file's stem>``, and its origin the fingerprint of all that it reads."""
        if self._path is None:
            raise UserError("scene=gltf needs a file: add path=FILE.gltf or path=FILE.glb.")
        from supersampling.scenes.gltf import fingerprint

        named = {
            f"gltf/{self._path.stem}" if name == "gltf" else name: origin for name, origin in self._origins.items()
        }
        self._origins = named | {f"gltf/{self._path.stem}": f"gltf:{fingerprint(self._path)}"}

    def specs(self, split: str) -> list[CaptureSpec]:
        options = dict(self._splits[split])
        window = options.pop("window") or self._frame
        options["targets"] = options["targets"] or options["frames"]
        return [
            CaptureSpec(
                scene=scene,
                split=split,
                origin=origin,
                frame=self._frame,
                window=(int(window[0]), int(window[1])),
                **options,
                **self._shared,
            )
            for scene, origin in self._origins.items()
        ]

    def files(self, splits: Sequence[str], buffers: frozenset[str]) -> dict[str, list[Path]]:
        from supersampling.render.pool import render_files

        specs = {split: self.specs(split) for split in splits}
        render_files(
            [s for split in splits for s in specs[split]],
            self._folder,
            buffers,
            self._workers,
            path=self._path,
        )
        return {split: [self._folder / spec.file_name for spec in specs[split]] for split in splits}
