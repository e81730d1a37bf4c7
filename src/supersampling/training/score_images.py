"""Scores images of another method, such as the DLSS and FSR ones that QRISP ships, against a data set's targets."""

import json
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor

from supersampling.data.readers.files import Root
from supersampling.data.readers.images import read_png
from supersampling.data.readers.qrisp import baseline_images
from supersampling.data.store import Store
from supersampling.errors import UserError
from supersampling.metrics.image import mssim_thesis, psnr, ssim_gauss11

METRICS = {"psnr": psnr, "ssim_gauss11": ssim_gauss11, "mssim_thesis": mssim_thesis}


def score_images(folder: Path, store: Store, clip: int) -> pd.DataFrame:
    """One row a frame of ``clip``: ``scene``, ``clip``, ``frame`` (from 0) and the metrics of `supersampling.metrics.image`.

    ``folder`` holds ``<number>.png`` of the target's size, one for each frame that has a target, in the same order.

    Raises:
        UserError: there are more or fewer images than targets, one is broken or of another size, or there is no such clip.
    """
    spec = store.spec
    if not 0 <= clip < store.clips:
        raise UserError(f"{store.path} has no clip {clip}: it has {store.clips}, from 0.")
    images = Root(folder).frames(folder.resolve(), ".png").files
    if len(images) != spec.targets:
        raise UserError(
            f"{folder} has {len(images)} images for the {spec.targets} targets of clip {clip} in {store.path}."
        )
    rows = []
    for frame, number in enumerate(sorted(images), start=spec.frames - spec.targets):
        output = _tensor(images[number], spec.target_size)
        target = torch.from_numpy(store.read("target", clip, slice(frame, frame + 1)))
        scores = {name: float(metric(output, target)) for name, metric in METRICS.items()}
        rows.append({"scene": spec.scene, "clip": clip, "frame": frame, **scores})
    return pd.DataFrame(rows)


def score_baselines(capture: Path, store: Store) -> pd.DataFrame:
    """The images of DLSS and FSR in a QRISP ``capture``, against the file that was imported from it: `score_images` of every
    method and clip, with the method's folder name in the column ``method``.

    Raises:
        UserError: as `score_images`, or the capture has no such images of a clip.
    """
    scene = store.spec.scene.removeprefix("qrisp/")
    segments = [label.rsplit("/", 1)[-1] for label in json.loads(store.attributes.get("clips", "[]"))]
    tables = []
    for method, images in baseline_images(capture, scene).items():
        for clip, segment in enumerate(segments):
            if segment not in images:
                raise UserError(
                    f"{capture} has no images of {method} for segment {segment} of {scene}: unpack them as well."
                )
            tables.append(score_images(images[segment].folder, store, clip).assign(method=method))
    if not tables:
        raise UserError(f"{store.path} was not imported from a QRISP capture: import it with layout qrisp.")
    return pd.concat(tables, ignore_index=True)


def _tensor(path: Path, size: tuple[int, int]) -> Tensor:
    return torch.from_numpy(read_png(path, size, 3).transpose(2, 0, 1).copy()).float()[None] / 255.0
