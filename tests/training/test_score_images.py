"""Images of other methods against a data set's targets."""

import numpy as np
import pytest
from PIL import Image
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from supersampling.data.spec import CaptureSpec
from supersampling.data.store import Store
from supersampling.data.writer import ClipWriter, join_clips
from supersampling.errors import UserError
from supersampling.training.score_images import score_images


@pytest.fixture
def targets(tmp_path):
    """A store of two clips of four frames, with targets for the last three, and the targets in 8 bits."""
    rng = np.random.default_rng(0)
    values = rng.integers(0, 256, (2, 3, 24, 32, 3), dtype=np.uint8)
    spec = CaptureSpec("qrisp/Noise", "test", 2, 4, 3, (32, 24), (32, 24), 2, "none", "matched", 1, 0, 1)
    parts = [tmp_path / f"{k}.h5" for k in range(2)]
    for part, clip in zip(parts, values):
        with ClipWriter(part, {"target": 3}) as writer:
            for image in clip:
                writer.add("target", image.astype(np.float32) / 255.0)
    join_clips(tmp_path / "all.h5", spec, parts, frozenset({"target"}), {})
    store = Store(tmp_path / "all.h5")
    yield store, values
    store.close()


def save(folder, images, first=0):
    folder.mkdir()
    for k, image in enumerate(images):
        Image.fromarray(image).save(folder / f"{first + k:04d}.png")
    return folder


def test_rows_agree_with_skimage(targets, tmp_path):
    store, values = targets
    rng = np.random.default_rng(1)
    outputs = np.clip(values[1].astype(int) + rng.integers(-30, 31, values[1].shape), 0, 255).astype(np.uint8)
    table = score_images(save(tmp_path / "fsr", outputs, first=8), store, 1)
    assert list(table.columns) == ["scene", "clip", "frame", "psnr", "ssim_gauss11", "mssim_thesis"]
    assert table[["scene", "clip", "frame"]].values.tolist() == [["qrisp/Noise", 1, k] for k in (1, 2, 3)]
    for row, output, target in zip(table.itertuples(), outputs, values[1]):
        assert row.psnr == pytest.approx(peak_signal_noise_ratio(target, output), abs=1e-3)
        x, y = output / 255.0, target / 255.0
        _, full = structural_similarity(
            x,
            y,
            gaussian_weights=True,
            sigma=1.5,
            use_sample_covariance=False,
            data_range=1.0,
            channel_axis=2,
            full=True,
        )
        assert row.ssim_gauss11 == pytest.approx(full[5:-5, 5:-5].mean(), abs=1e-5)


def test_the_target_itself_is_perfect(targets, tmp_path):
    store, values = targets
    table = score_images(save(tmp_path / "same", values[0]), store, 0)
    assert (table["psnr"] == 100.0).all()
    np.testing.assert_allclose(table["ssim_gauss11"], 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ("images", "clip", "told"),
    [
        (np.zeros((2, 24, 32, 3), np.uint8), 0, "2 images for the 3 targets"),
        (np.zeros((3, 24, 30, 3), np.uint8), 0, "30x24 pixels instead of 32x24"),
        (np.zeros((3, 24, 32), np.uint8), 0, "of kind L"),
        (np.zeros((3, 24, 32, 3), np.uint8), 2, "no clip 2"),
    ],
)
def test_what_does_not_belong_is_refused(targets, tmp_path, images, clip, told):
    with pytest.raises(UserError, match=told):
        score_images(save(tmp_path / "odd", images), targets[0], clip)
