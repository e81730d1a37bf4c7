import numpy as np
import pytest
import torch
from video_clips import moments, passing_square, score

from supersampling.errors import UserError
from supersampling.metrics.video.base import VideoSuite, to_bytes
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.epipolar import EpipolarPlane
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError

METRICS = [StaticDeviation(), WarpingError(DualMotion()), WarpingError(Photometric()), StRred(), Vmaf()]


def count_elements(value) -> int:
    """Return the bytes of all tensors and arrays of an object."""
    if isinstance(value, torch.Tensor | np.ndarray):
        return value.nbytes
    if isinstance(value, dict):
        return sum(count_elements(v) for v in value.values())
    if isinstance(value, list | tuple):
        return sum(count_elements(v) for v in value)
    return count_elements(vars(value)) if type(value).__module__.startswith("supersampling") else 0


def test_suite_equals_its_separate_metrics():
    targets, motions, duals = passing_square(4)
    outputs = [image * 0.9 for image in targets]
    suite = VideoSuite(METRICS)
    together = score(suite, outputs, targets, motions, duals)
    assert tuple(together) == suite.names
    assert len(set(suite.names)) == len(suite.names)
    alone = [score(metric, outputs, targets, motions, duals) for metric in METRICS]
    assert together == pytest.approx({k: v for values in alone for k, v in values.items()}, nan_ok=True)
    assert suite.requires == {"target", "motion", "motion_dual"}
    assert score(VideoSuite(), outputs, targets) == {}


@pytest.mark.parametrize("metric", [*METRICS, ColorVideoVdp()], ids=lambda m: m.names[0])
def test_memory_does_not_grow_with_the_clip(metric):
    """The size of the state after 6 frames equals that after 24; both are even, for the pairs of ST-RRED."""
    if isinstance(metric, ColorVideoVdp):
        pytest.importorskip("pycvvdp")
    targets, motions, duals = passing_square(6)
    with metric.begin() as scoring:
        sizes = []
        for _ in range(4):
            for moment in moments(targets, targets, motions, duals):
                scoring.add(moment)
            sizes.append(count_elements(scoring))
    assert sizes == sizes[:1] * 4


def test_bytes_are_rounded_and_cut():
    image = torch.tensor([-1.0, 0.0, 0.49 / 255, 0.51 / 255, 1.0, 7.0]).expand(1, 3, 1, 6)
    assert to_bytes(image)[0, :, 1].tolist() == [0, 0, 0, 1, 255, 255]
    assert to_bytes(image).shape == (1, 6, 3)


def test_epipolar_plane_is_one_row_over_time():
    targets, _, _ = passing_square(5)
    plane = EpipolarPlane(0.5, longest=4)
    for image in targets:
        plane.add(image * 0.5, image)
    output, target = plane.images()
    assert output.shape == target.shape == (4, 64, 3)
    for t in range(4):
        np.testing.assert_array_equal(target[t], to_bytes(targets[t])[24])
        np.testing.assert_array_equal(output[t], to_bytes(targets[t] * 0.5)[24])
    with pytest.raises(UserError, match="without frames"):
        EpipolarPlane().images()
    with pytest.raises(UserError, match="place=1.5"):
        EpipolarPlane(1.5)
