"""Every metric that the project computes has a stated direction, the one of its paper or definition."""

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import supersampling.metrics
from supersampling.metrics.lpips import LPIPS, NETWORKS
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError
from supersampling.reporting.directions import better
from supersampling.reporting.papers.published import load_paper

ROOT = Path(__file__).resolve().parents[2]
# The names of metrics whose convention is an argument. LPIPS is not made here: it needs weights.
MADE: dict[str, list[str]] = {
    LPIPS.__name__: [f"lpips_{network}" for network in NETWORKS],
    ColorVideoVdp.__name__: [
        name
        for metric in (ColorVideoVdp(), ColorVideoVdp(30.0), ColorVideoVdp(display="standard_4k"))
        for name in metric.names
    ],
    Vmaf.__name__: [name for model in ("vmaf_v0.6.1", "vmaf_4k_v0.6.1") for name in Vmaf(model).names],
    WarpingError.__name__: [
        name for visibility in (DualMotion(), Photometric()) for name in WarpingError(visibility).names
    ],
    "VideoSuite": [],  # has those of its metrics
    "Untrained": [],  # stands in for LPIPS
}
NEITHER = {
    "fraction_disoccluded", "fraction_static", "static_std_reference", "static_std_fraction", "warping_error_reference",
    "warping_error_ratio", "warping_error_photometric_reference", "warping_error_photometric_ratio",
}  # fmt: skip


def metric_classes() -> Iterator[type]:
    """All classes of the package that state or set ``names``, but the abstract ones."""
    for module in pkgutil.walk_packages(supersampling.metrics.__path__, "supersampling.metrics."):
        for _, found in inspect.getmembers(importlib.import_module(module.name), inspect.isclass):
            declared = any("names" in inspect.get_annotations(base) for base in found.__mro__)
            names = declared or "names" in vars(found)
            if found.__module__ == module.name and names and not inspect.isabstract(found):
                yield found


def names_of(metric: type) -> list[str]:
    return list(metric.names) if "names" in vars(metric) else MADE[metric.__name__]  # type: ignore[attr-defined]


NAMES = sorted({name for metric in metric_classes() for name in names_of(metric)})


def test_all_are_found():
    assert {"psnr", "flip_hdr", "psnr_disoccluded", "trred", "lpips_alex", "vmaf", "cvvdp"} <= set(NAMES)
    assert set(NAMES) >= NEITHER


@pytest.mark.parametrize("name", NAMES)
def test_each_is_stated(name):
    way = better(name)
    assert way is not None, f"reporting/directions.py does not state {name}"
    assert (way == "neither") == (name in NEITHER)


def test_those_of_the_papers_agree_with_them():
    for path in (ROOT / "reports" / "published").glob("*.yaml"):
        for metric in load_paper(path).metrics.values():
            if metric.ours is not None and "/" not in metric.ours:  # the rest is never measured, or logged by runs
                assert better(metric.ours) == metric.better, (path.name, metric.ours)


def test_those_of_the_documentation_agree_with_it():
    """docs/metrics.md says it in the second column of its tables, for people."""
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in (ROOT / "docs" / "metrics.md").read_text().splitlines()
    ]
    told = {
        name.strip(" `"): row[1]
        for row in rows
        if len(row) > 2 and row[1] in ("higher", "lower", "neither")
        for name in row[0].split(",")
    }
    assert "psnr" in told
    assert {name: better(name) for name in told} == told


@pytest.mark.parametrize("name", ["psnrish", "secret", "my_reference", ""])
def test_what_is_not_stated_is_not_guessed(name):
    assert better(name) is None


def test_distances_and_qualities_by_their_definitions():
    for name in (
        "psnr_hdr_mu",
        "psnr_static",
        "ssim_uniform11",
        "mssim_thesis",
        "cvvdp_30fps",
        "vmaf_4k_v0.6.1",
    ):
        assert better(name) == "higher"
    for name in ("flip_hdr", "lpips_vgg", "temporal", "srred", "warping_error_photometric", "static_std"):
        assert better(name) == "lower"
