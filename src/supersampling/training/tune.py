"""Constants of a classical method, tuned on the training clips: the grid point with the best mean PSNR."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np
import torch
from tqdm import tqdm

from supersampling.data.clips import WholeClips
from supersampling.frames import Frame, clip_length
from supersampling.metrics.image import psnr
from supersampling.models.base import Upsampler

CLIPS = 12  # spread evenly over the training clips
WARM_UP = 4  # frames of each clip that do not count


@torch.inference_mode()
def _mean_psnr(model: Upsampler, clips: list[dict[str, torch.Tensor]]) -> float:
    values = []
    for clip in clips:
        state = None
        batch = {name: values.unsqueeze(0) for name, values in clip.items()}
        length = clip_length(batch)
        first = length - len(clip["target"])
        for t in range(length):
            frame = Frame.from_clip(batch, t)
            output, state = model(frame, state)
            output = model.present(output, frame)
            if t >= max(first, WARM_UP):
                values.append(psnr(output, clip["target"][t - first : t - first + 1]).item())
    return float(np.mean(values))


def tune(
    make: Callable[[Mapping[str, float]], Upsampler], grid: Mapping[str, Sequence[float]], clips: WholeClips
) -> tuple[dict[str, float], float]:
    """Try every combination of ``grid`` on some training clips; return the best constants and their mean PSNR in dB."""
    indices = np.unique(np.linspace(0, len(clips) - 1, CLIPS).astype(int))
    sample = [clips[int(k)] for k in indices]
    trials = [dict(zip(grid, values)) for values in product(*grid.values())]
    scores = [_mean_psnr(make(trial), sample) for trial in tqdm(trials, desc="tune", unit="trial", leave=False)]
    best = int(np.argmax(scores))
    return trials[best], scores[best]
