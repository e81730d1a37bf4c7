import torch

from supersampling.ops.colour import rgb_to_ycocg, ycocg_to_rgb

TO_YCOCG = torch.tensor([[1.0, 2.0, 1.0], [2.0, 0.0, -2.0], [-1.0, 2.0, -1.0]], dtype=torch.float64) / 4.0
TO_RGB = torch.tensor([[1.0, 1.0, -1.0], [1.0, 0.0, 1.0], [1.0, -1.0, -1.0]], dtype=torch.float64)


def test_conversions_equal_the_published_matrices():
    image = torch.rand(2, 3, 4, 5, dtype=torch.float64)
    torch.testing.assert_close(rgb_to_ycocg(image), torch.einsum("ij,bjhw->bihw", TO_YCOCG, image))
    torch.testing.assert_close(ycocg_to_rgb(image), torch.einsum("ij,bjhw->bihw", TO_RGB, image))


def test_round_trip():
    image = torch.rand(3, 4, 5)
    torch.testing.assert_close(ycocg_to_rgb(rgb_to_ycocg(image)), image)
