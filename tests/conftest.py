"""Fixtures shared by all tests: pinned threads, and an analytic clip with a closed-form reference."""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
from answers import Answer
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from numpy.typing import NDArray
from omegaconf import DictConfig, open_dict

from supersampling.commands.entry import FAILED, launch
from supersampling.commands.resolvers import register
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, join_clips

ROOT = Path(__file__).resolve().parents[1]
os.environ["SUPERSAMPLING_ROOT"] = str(ROOT)
register()


@pytest.fixture(autouse=True, scope="session")
def _pinned_threads() -> Iterator[None]:
    torch.set_num_threads(1)
    return


def pattern(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a colour in [0, 1] for every point of the plane (target pixels): three plane waves per channel."""
    waves = ((0.31, 0.17, 0.4), (-0.23, 0.37, 1.9), (0.11, -0.29, 3.1))
    channels = [0.5 + 0.15 * sum(np.sin(a * x * (1 + 0.2 * c) + b * y + p + c) for a, b, p in waves) for c in range(3)]
    return np.stack(channels, axis=-1)


def analytic_clip(
    frames: int, width: int, height: int, scale: int, velocity: tuple[float, float], jitter: NDArray[np.float32]
) -> dict[str, NDArray]:
    """Return the usual buffers of a plane that moves by ``velocity`` target pixels per frame, in closed form.

    The target is the pattern at target pixel centres (it is so smooth that box filtering has almost no effect).
    """
    clip: dict[str, list[NDArray]] = {name: [] for name in ("color", "depth", "motion", "jitter", "target")}
    for t in range(frames):
        dx, dy = velocity[0] * t, velocity[1] * t
        y, x = np.mgrid[0:height, 0:width] + 0.5
        clip["target"].append(pattern(x - dx, y - dy).astype(np.float32))
        j = jitter[t % len(jitter)]
        y, x = np.mgrid[0 : height // scale, 0 : width // scale] + 0.5
        color = pattern((x + j[0]) * scale - dx, (y + j[1]) * scale - dy)
        clip["color"].append(color.astype(np.float32))
        clip["depth"].append(np.full((*x.shape, 1), 0.5, dtype=np.float32))
        motion = np.array((-velocity[0] / width, -velocity[1] / height), dtype=np.float32)
        clip["motion"].append(np.broadcast_to(motion, (*x.shape, 2)).copy())
        clip["jitter"].append(j)
    return {name: np.stack(values) for name, values in clip.items()}


@pytest.fixture(scope="session")
def make_file() -> Callable[..., Path]:
    """Return a function that writes analytic clips: ``make_file(folder, split, clips=, frames=, size=, scale=)``."""
    from supersampling.render.jitter import jitter_sequence

    def make(
        folder: Path, split: str = "train", clips: int = 2, frames: int = 8, size: int = 48, scale: int = 4
    ) -> Path:
        spec = CaptureSpec(
            scene="analytic",
            split=split,
            clips=clips,
            frames=frames,
            targets=frames,
            frame=(size, size),
            window=(size, size),
            scale=scale,
            jitter="thesis",
            mip_bias="matched",
            samples=1,
            seed=0,
            candidates=1,
        )
        sequence = jitter_sequence("thesis", scale)
        rng = np.random.default_rng(len(split))
        velocities = [tuple(rng.uniform(-3, 3, 2)) for _ in range(clips)]
        buffers = [analytic_clip(frames, size, size, scale, velocity, sequence) for velocity in velocities]
        path = folder / spec.file_name
        parts = [folder / f"{split}_{k}.clip" for k in range(clips)]
        for part, clip in zip(parts, buffers):
            with ClipWriter(part, dict.fromkeys(clip, frames)) as writer:
                for name, values in clip.items():
                    for image in values:
                        writer.add(name, image)
        join_clips(path, spec, parts, frozenset(buffers[0]), {"renderer": "closed form"})
        for part in parts:
            part.unlink()
        return path

    return make


@pytest.fixture
def entry() -> Iterator[Callable[..., DictConfig]]:
    """Return a function that composes an entry point's configuration: ``entry("evaluate", "scene=atrium", ...)``."""

    def make(name: str, *overrides: str) -> DictConfig:
        GlobalHydra.instance().clear()
        with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
            cfg = compose(name, list(overrides), return_hydra_config=True)
        HydraConfig.instance().set_config(cfg)
        with open_dict(cfg):
            del cfg["hydra"]
        return cfg

    yield make
    HydraConfig.instance().cfg = None


@pytest.fixture
def command(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Answer]]:
    """Return a function that runs a command in this process: ``command("evaluate", "model=jau", ...)``.

    An error of ours fails the test with its stack trace. Pass ``threads=1`` to commands that have the setting.
    """

    def call(name: str, *arguments: str) -> Answer:
        GlobalHydra.instance().clear()
        monkeypatch.setattr(sys, "argv", [f"{name}.py"])
        FAILED.clear()
        capfd.readouterr()
        status = 0
        try:
            launch(name, arguments)
        except SystemExit as end:
            status = int(end.code or 0)
        out, err = capfd.readouterr()
        return Answer(status, out, err)

    # Hydra gives the root logger handlers that write to this test's captured output.
    root = logging.getLogger()
    level, handlers = root.level, root.handlers[:]
    yield call
    root.setLevel(level)
    root.handlers[:] = handlers
    GlobalHydra.instance().clear()
    HydraConfig.instance().cfg = None


@pytest.fixture
def vgg(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the pretrained VGG-16 by 13 random convolutions of one channel each: tests do not download weights."""
    from supersampling.losses import perceptual

    torch.manual_seed(0)
    pairs = tuple((torch.randn(1, 1 if k else 3, 3, 3), torch.zeros(1)) for k in range(13))
    small = perceptual.Pretrained(pairs, (0.5,) * 3, (0.25,) * 3)
    monkeypatch.setattr(perceptual, "pretrained", lambda weights: small)


@pytest.fixture(scope="session")
def raft_home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder for ``TORCH_HOME`` with random weights under the file names of pretrained RAFT."""
    from torchvision.models import get_model, get_model_weights

    home = tmp_path_factory.mktemp("torch")
    folder = home / "hub" / "checkpoints"
    folder.mkdir(parents=True)
    torch.manual_seed(0)
    for network, weights in (("raft_large", "C_T_SKHT_V2"), ("raft_small", "C_T_V2")):
        name = get_model_weights(network)[weights].url.rsplit("/", 1)[-1]
        torch.save(get_model(network, weights=None).state_dict(), folder / name)
    return home


@pytest.fixture
def raft(raft_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Use random weights in place of pretrained RAFT."""
    monkeypatch.setenv("TORCH_HOME", str(raft_home))


@pytest.fixture(scope="session")
def new_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an empty store, which takes MLflow seconds to create; tests copy it."""
    from supersampling.runs.database import create_database

    path = tmp_path_factory.mktemp("store") / "mlflow.db"
    create_database(path)
    return path
