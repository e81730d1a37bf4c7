"""Which way each metric is better, stated here and nowhere else."""

from typing import Literal

Better = Literal["higher", "lower", "neither"]

# By the beginning of a metric's name, whose rest is its convention; the longest beginning counts.
DIRECTIONS: dict[str, Better] = {
    "psnr": "higher",
    "ssim": "higher",
    "mssim": "higher",
    "vmaf": "higher",
    "cvvdp": "higher",
    "spatial": "lower",
    "temporal": "lower",
    "lpips": "lower",
    "flip": "lower",
    "strred": "lower",
    "srred": "lower",
    "trred": "lower",
    "warping_error": "lower",
    "static_std": "lower",
    "fraction": "neither",
}
# Values that describe the target or the clip, and a ratio, which is best near 1. They outrank a name's beginning.
NEITHER = ("_reference", "_ratio", "_fraction")


def better(metric: str) -> Better | None:
    """Whether more or less of ``metric`` is better, or neither; ``None`` where nothing is stated. Neither lets a side win."""
    known = [start for start in DIRECTIONS if metric == start or metric.startswith(f"{start}_")]
    if not known:
        return None
    return "neither" if metric.endswith(NEITHER) else DIRECTIONS[max(known, key=len)]
