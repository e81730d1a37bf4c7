"""The interface of all methods: every frame is repaired before a model reads it."""

import pytest
import torch
import torch.nn.functional as F

from supersampling.frames import Frame
from supersampling.models.base import Upsampler


class ReadsOnly(Upsampler):
    """Nearest-neighbour colour; the state is the frame's colour."""

    scale = 2
    requires = frozenset({"color"})

    def forward(self, frame, state):
        return F.interpolate(frame.need("color"), scale_factor=self.scale), frame.need("color")


class SkipsOutput(ReadsOnly):
    """A model whose state is computed without its output."""

    def forward(self, frame, state):
        raise AssertionError("The output is not needed.")

    def forward_state(self, frame, state):
        return frame.need("color")


@pytest.mark.parametrize("model", [ReadsOnly(), SkipsOutput()], ids=lambda model: type(model).__name__)
def test_advance_repairs_the_frame_before_any_override_sees_it(model):
    color = torch.rand(1, 3, 4, 5)
    color[0, 0, 1, 2], color[0, 1, 2, 3] = torch.nan, torch.inf
    state = model.advance(Frame(color=color), None)
    assert torch.equal(state, Frame(color=color).repair().need("color"))
    assert state.isfinite().all()


def test_advance_of_the_default_is_one_forward_with_its_hooks():
    model, calls = ReadsOnly(), []
    model.register_forward_hook(lambda *_: calls.append(1))
    model.advance(Frame(color=torch.rand(1, 3, 4, 5)), None)
    assert calls == [1]
