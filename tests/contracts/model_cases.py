"""What the contract tests share: every option of every stage of every model, as conf/model has them, and clips to run
them on.

A yaml in ``conf/model/`` is a model, one in ``conf/model/<slot>/`` an option of a stage: nobody has to name them here.
"""

import copy
import tempfile
import zlib
from functools import cache
from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
import yaml
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import InstantiationException
from hydra.utils import instantiate

from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame, clip_length

CONF = Path(__file__).resolve().parents[2] / "conf"
# What a yaml says and no contract hangs on: a narrow kernel-predicting network, as budgets have it.
SMALL = ("+task.scale=2", "+budget.mlp_width=16")
# Constructor numbers whose ends are other programs: no window at all, and one that is a single frame.
NUMBERS = [("nsrr", "model.previous=0"), ("nsrr", "model.previous=1"), ("nsrd", "model.previous=1")]


def stems(folder):
    return sorted(path.stem for path in (CONF / folder).glob("*.yaml"))


def _written(name):
    return yaml.safe_load((CONF / "model" / f"{name}.yaml").read_text())


MODELS = stems("model")
# Those that name a class themselves; the others are one of these with other numbers.
FAMILIES = [name for name in MODELS if "_target_" in _written(name)]


def family_of(name):
    """The model itself, or the one whose numbers it overrides."""
    if name in FAMILIES:
        return name
    return family_of(next(line for line in _written(name)["defaults"] if line in MODELS))


def slots_of(family):
    """``{slot: the published option}`` of a model's yaml."""
    lines = _written(family).get("defaults", [])
    return {slot: option for line in lines if isinstance(line, dict) for slot, option in line.items()}


SLOTS = {family: slots_of(family) for family in FAMILIES}
OPTIONS = [
    (family, f"model/{slot}={option}")
    for family, slots in SLOTS.items()
    for slot, published in slots.items()
    for option in stems(f"model/{slot}")
    if option != published
]
VARIANTS = [*((name,) for name in MODELS), *OPTIONS, *NUMBERS]
every_variant = pytest.mark.parametrize("variant", VARIANTS, ids=" ".join)


@cache
def config_of(*variant):
    """``(model, override, ...)`` composed by itself; which settings of ``train.yaml`` lead there is `test_ablations`'
    matter."""
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose(None, [f"+model={variant[0]}", *SMALL, *variant[1:]])


def _offline(*args, **kwargs):
    raise OSError("no download in a test")


@cache
def _attempt(variant, dtype):
    torch.manual_seed(0)
    with tempfile.TemporaryDirectory() as empty, pytest.MonkeyPatch.context() as patch:
        patch.setenv("TORCH_HOME", empty)
        patch.setattr(torch.hub, "download_url_to_file", _offline)
        try:
            model = instantiate(config_of(*variant).model).to(dtype)
        except InstantiationException as error:
            return error
    for p in model.parameters():
        if not p.any():  # at 0 a layer hides what goes into it: predicted kernels are one for all items
            p.data.normal_(0.0, 0.05)
    return model


def model_of(*variant, dtype=torch.float64):
    """The model, which tests share: `trained_copy` is for those that change it.

    Pretrained weights are out of reach here. An option that needs some has to say which file goes where, and nothing
    more can be
    tested: `test_ablations` runs it with random ones.
    """
    made = _attempt(variant, dtype)
    if isinstance(made, InstantiationException):
        cause = made.__cause__
        if (
            isinstance(cause, UserError)
            and "put the file https://" in str(cause)
            and f" at {tempfile.gettempdir()}" in str(cause)
        ):
            pytest.skip(f"{variant[-1]} needs pretrained weights")
        raise made
    return made


def trained_copy(*variant):
    return copy.deepcopy(model_of(*variant, dtype=torch.float32))


def clip(names, scale=2, frames=3, b=2, h=5, w=6, seed=0, motion=0.1, dtype=torch.float64):
    """Random values of exactly these buffers, each what it is whichever others are there; ``motion`` is the largest."""
    size = {"low": (h, w), "high": (h * scale, w * scale), "frame": ()}

    def values(name):
        buffer = BUFFERS[name]
        g = torch.Generator().manual_seed(zlib.crc32(name.encode()) + seed)
        shape = (b, frames, buffer.channels, *size[buffer.resolution])
        x = torch.rand(shape, generator=g, dtype=torch.float64)
        if name == "jitter":
            return x - 0.5
        if name == "motion_dual":  # the motion itself where nothing was hidden
            hidden = torch.rand((b, frames, 1, h, w), generator=g, dtype=torch.float64) > 0.7
            return torch.where(hidden, (2 * x - 1) * motion, values("motion"))
        made = {
            "plane": (2 * x - 1) * motion,
            "direction": F.normalize(2 * x - 1, dim=2),
            "id": (5 * x).floor(),
            "reflectance": x + 0.1 if buffer.range == "[0, 2]" else x,
            "light": 0.5 * x if "emission" in name else x + 0.5,
        }
        return made.get(buffer.kind, x)

    return {name: values(name).to(dtype) for name in sorted(names)}


def run(model, buffers, state=None):
    """Outputs ``(B, T, 3, H, W)`` of a clip, all of whose buffers are handed in; and the state after each frame."""
    outputs, states = [], []
    for t in range(clip_length(buffers)):
        output, state = model(Frame.from_clip(buffers, t), state)
        outputs.append(output)
        states.append(state)
    return torch.stack(outputs, dim=1), states


def shown(model, buffers, outputs=None):
    """What is displayed of a clip, ``(B, T, 3, H, W)``."""
    outputs = run(model, buffers)[0] if outputs is None else outputs
    images = [model.present(outputs[:, t], Frame.from_clip(buffers, t)) for t in range(outputs.shape[1])]
    return torch.stack(images, dim=1)
