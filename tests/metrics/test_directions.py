"""Every metric of the project states its direction, that of its paper or definition."""

import inspect
from pathlib import Path

import pytest

from supersampling.metrics.base import Metric
from supersampling.metrics.directions import better, metric_classes
from supersampling.metrics.lpips import LPIPS, Untrained
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError
from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.schema import BENCHMARK

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = (ROOT / "docs" / "metrics.md").read_text()
NAMES = sorted({name for metric in metric_classes() for name in metric.better if "*" not in name})
# Metrics whose names depend on an argument. LPIPS needs weights: `Untrained` has its names.
BY_ARGUMENT = [
    *(Untrained(network) for network in ("alex", "vgg")),
    *(ColorVideoVdp(), ColorVideoVdp(30.0), ColorVideoVdp(display="standard_4k")),
    *(Vmaf(model) for model in ("vmaf_v0.6.1", "vmaf_4k_v0.6.1")),
    *(WarpingError(visibility) for visibility in (DualMotion(), Photometric())),
]
NEITHER = [
    "fraction_disoccluded",
    "fraction_static",
    "static_std_reference",
    "static_std_fraction",
    "warping_error_reference",
    "warping_error_ratio",
    "warping_error_photometric_reference",
    "warping_error_photometric_ratio",
]


def test_all_metrics_are_collected():
    assert {"psnr", "flip_hdr", "psnr_disoccluded", "trred", "fraction_static"} <= set(NAMES)


def subclasses(base: type) -> set[type]:
    return {base, *(leaf for child in base.__subclasses__() for leaf in subclasses(child))}


def test_each_metric_class_states_its_directions():
    stated = set(metric_classes())
    for metric in subclasses(Metric):
        if metric.__module__.startswith("supersampling.") and not inspect.isabstract(metric):
            assert metric in stated or metric.__name__ in ("Metric", "FrameSuite", "VideoSuite"), metric


def test_no_name_has_two_directions():
    stated = [(name, metric) for metric in metric_classes() for name in metric.better if metric is not Untrained]
    assert len({name for name, _ in stated}) == len(stated)
    assert Untrained.better == LPIPS.better


@pytest.mark.parametrize("name", NAMES)
def test_each_name_is_documented(name):
    assert f"`{name}`" in DOCUMENT


@pytest.mark.parametrize("name", [name for metric in BY_ARGUMENT for name in metric.names])
def test_names_that_depend_on_argument_are_resolved(name):
    assert better(name) is not None


@pytest.mark.parametrize("name", NEITHER)
def test_values_that_describe_the_target_or_the_clip_have_no_direction(name):
    assert better(name) == "neither"


def test_directions_agree_with_the_papers():
    for path in (ROOT / "reports" / "published").glob("*.yaml"):
        for metric in load_paper(path).metrics.values():
            # Other quantities are never measured here, or are logged by runs.
            if metric.logged is not None and metric.logged.startswith(BENCHMARK):
                assert metric.better == "lower", (path.name, metric.logged)  # times and sizes
            elif metric.logged is not None and "/" not in metric.logged:
                assert better(metric.logged) == metric.better, (path.name, metric.logged)


def test_directions_agree_with_the_documentation():
    """The second column of the tables in docs/metrics.md."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in DOCUMENT.splitlines()]
    documented = {
        name.strip(" `"): row[1]
        for row in rows
        if len(row) > 2 and row[1] in ("higher", "lower", "neither")
        for name in row[0].split(",")
    }
    assert "psnr" in documented
    assert {name: better(name) for name in documented} == documented


@pytest.mark.parametrize("name", ["psnrish", "secret", "my_reference", ""])
def test_unknown_names_have_no_direction(name):
    assert better(name) is None


def test_distances_and_qualities_by_their_definitions():
    for name in ("psnr_hdr_mu", "psnr_static", "ssim_uniform11", "ssim_zero_pad11", "cvvdp_30fps", "vmaf_4k_v0.6.1"):
        assert better(name) == "higher"
    for name in ("flip_hdr", "lpips_vgg", "temporal", "srred", "warping_error_photometric", "static_std"):
        assert better(name) == "lower"
