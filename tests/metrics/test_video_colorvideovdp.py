import math
import sys

import numpy as np
import pytest
import torch
from video_clips import moments, noisy, pan, score

from supersampling.errors import UserError
from supersampling.metrics.video.base import to_bytes
from supersampling.metrics.video.colorvideovdp import ColorVideoVdp

pycvvdp = pytest.importorskip("pycvvdp")


def test_equals_the_package_on_arrays():
    targets, _ = pan(4, 32, 40)
    outputs = noisy(targets, 0.1)
    films = [np.stack([to_bytes(f) for f in clip]).astype(np.float32) / 255 for clip in (outputs, targets)]
    expected, _ = pycvvdp.cvvdp(display_name="standard_fhd", quiet=True).predict(
        *films, dim_order="FHWC", frames_per_second=60
    )
    assert 1 < float(expected) < 9.9
    assert score(ColorVideoVdp(), outputs, targets)["cvvdp"] == pytest.approx(float(expected), abs=1e-4)


def test_names_include_display_and_frame_rate():
    assert ColorVideoVdp().names == ("cvvdp",)
    assert ColorVideoVdp(30.0, "standard_4k").names == ("cvvdp_standard_4k_30fps",)


def test_edges():
    assert math.isnan(score(ColorVideoVdp(), [], [])["cvvdp"])
    with pytest.raises(UserError, match="frame_rate=0"):
        ColorVideoVdp(0.0)
    with pytest.raises(UserError, match="no_such_display"):
        ColorVideoVdp(60.0, "no_such_display").begin()
    with pytest.raises(UserError, match="9x3"):
        score(ColorVideoVdp(), [torch.zeros(1, 3, 3, 9)], [torch.zeros(1, 3, 3, 9)])


def test_clip_of_one_frame_is_scored_as_an_image():
    output, target = torch.rand(2, 1, 3, 24, 32, generator=torch.Generator().manual_seed(0))
    expected, _ = pycvvdp.cvvdp(display_name="standard_fhd", quiet=True).predict(
        to_bytes(output), to_bytes(target), dim_order="HWC"
    )
    assert 1 < float(expected) < 9.9
    assert score(ColorVideoVdp(), [output], [target])["cvvdp"] == pytest.approx(float(expected), abs=1e-4)


def test_missing_package_is_an_error_before_the_first_frame(monkeypatch):
    monkeypatch.setitem(sys.modules, "pycvvdp", None)
    with pytest.raises(UserError, match="pip install cvvdp"):
        ColorVideoVdp().begin()


def test_frames_go_to_file_that_close_deletes():
    scoring = ColorVideoVdp().begin()
    with scoring:
        image = torch.rand(1, 3, 4, 6)
        for moment in moments([image] * 3, [image] * 3):
            scoring.add(moment)
        assert scoring._file.tell() == 3 * 2 * 4 * 6 * 3
    assert scoring._file.closed
