import pytest
import torch

from supersampling.ops.colour import rgb_to_ycocg, ycocg_to_rgb
from supersampling.stages.colour_space import RGB, YCoCg
from supersampling.stages.rectify import Clamp, Clip, NoRectification

SPACES = {"rgb": (RGB(), lambda c: c, lambda c: c), "ycocg": (YCoCg(), rgb_to_ycocg, ycocg_to_rgb)}


def rectify_by_loops(history, color, into, back, clip):
    _, _, h, w = color.shape
    scale = history.shape[-1] // w
    color, history = into(color)[0], into(history)[0]
    result = torch.empty_like(history)
    for i in range(h * scale):
        for j in range(w * scale):
            y, x = i // scale, j // scale
            near = color[:, max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2].flatten(1)
            low, high, mean = near.min(1).values, near.max(1).values, near.mean(1)
            old = history[:, i, j]
            if clip:
                # Bisect for the last point on the line from the mean that is still in the box.
                inside, beyond = 0.0, 1.0
                if ((old >= low) & (old <= high)).all():
                    inside = 1.0
                for _ in range(60 if inside == 0.0 else 0):
                    middle = 0.5 * (inside + beyond)
                    point = mean + middle * (old - mean)
                    inside, beyond = (middle, beyond) if ((point >= low) & (point <= high)).all() else (inside, middle)
                result[:, i, j] = mean + inside * (old - mean)
            else:
                result[:, i, j] = torch.minimum(torch.maximum(old, low), high)
    return back(result[None])


@pytest.mark.parametrize("name", SPACES)
@pytest.mark.parametrize("option", [Clamp, Clip])
@pytest.mark.parametrize(("h", "w", "scale"), [(4, 3, 2), (1, 2, 3)])
def test_equals_the_loops(name, option, h, w, scale):
    space, into, back = SPACES[name]
    color = torch.rand(1, 3, h, w, dtype=torch.float64) * 0.4 + 0.3
    history = torch.rand(1, 3, h * scale, w * scale, dtype=torch.float64)
    expected = rectify_by_loops(history, color, into, back, clip=option is Clip)
    torch.testing.assert_close(option(space)(history, color), expected)


@pytest.mark.parametrize("option", [Clamp, Clip])
def test_a_flat_neighbourhood_becomes_its_colour_without_nan(option):
    color = torch.tensor([0.2, 0.5, 0.7]).view(1, 3, 1, 1).expand(1, 3, 3, 3)
    history = torch.rand(1, 3, 6, 6)
    history[..., 0, 0] = color[..., 0, 0]
    history.requires_grad_()
    result = option(RGB())(history, color)
    torch.testing.assert_close(result, color[..., :1, :1].expand(1, 3, 6, 6))
    result.sum().backward()
    assert history.grad.isfinite().all()


def test_none_keeps_history():
    history = torch.rand(1, 3, 4, 4)
    assert torch.equal(NoRectification()(history, torch.zeros(1, 3, 2, 2)), history)
