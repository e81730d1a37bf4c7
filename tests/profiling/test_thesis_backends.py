"""The thesis's optimisations as backends: images, the parts that they name alike, and other methods."""

import pytest
import torch
from hydra.utils import instantiate

from supersampling.deploy.check import random_frames
from supersampling.errors import UserError
from supersampling.models.bicubic import Bicubic
from supersampling.profiling.backends import Eager, LoadOptions
from supersampling.profiling.parts import Recorder, measure_parts
from supersampling.profiling.thesis import Optimisation1, Optimisations1And2
from supersampling.render.jitter import jitter_sequence

CPU = torch.device("cpu")
OPTIONS = LoadOptions(width=16, height=12, precision="float32", device=CPU, threads=1)
RESIDUAL_NETWORK = {"network.down", *(f"network.blocks.{k}" for k in range(4))}


@pytest.mark.parametrize("scale", [2, 4])
@pytest.mark.parametrize("backend", [Optimisation1(), Optimisations1And2()], ids=lambda b: b.name)
def test_images_and_parts_of_an_optimisation(composed, backend, scale):
    config = composed("model=dlctus", f"task.scale={scale}").model
    images, parts = [], []
    for item in (Eager(), backend):
        torch.manual_seed(0)
        model = instantiate(config)
        frames = list(random_frames(model, (16, 12), 4, torch.from_numpy(jitter_sequence("thesis", scale))))
        stream = item.load(model, OPTIONS)
        images.append(torch.stack([stream.image(stream.step(stream.prepare(frame))) for frame in frames]))
        step = iter(frames)
        recorder = Recorder(CPU, 2)
        parts.append({p.part for p in measure_parts(stream.model, lambda: stream.step(next(step)), 4, recorder)})  # noqa: B023
    assert (images[0] - images[1]).abs().max() < 1e-4
    assert (images[0][-1] - images[0][0]).abs().max() > 1e-2
    plain, rewritten = parts
    assert {"prepare_input", "network", "construct"} | RESIDUAL_NETWORK | {"network.up"} <= plain
    assert {"prepare_input", "network", "construct_image"} | RESIDUAL_NETWORK <= rewritten
    assert "network.up" not in rewritten


@pytest.mark.parametrize("backend", [Optimisation1(), Optimisations1And2()], ids=lambda b: b.name)
def test_other_methods_are_refused_with_their_name(backend):
    with pytest.raises(UserError, match=f"The {backend.name} backend runs DLCTUS only, not Bicubic: leave"):
        backend.load(Bicubic(2), OPTIONS)
    assert "int8" in backend.missing(CPU, "int8")
