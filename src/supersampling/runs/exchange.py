"""Stages exchanged after training: the trained weights in a model that differs in what the command line names.

So the thesis compares reprojections and dilation: one training, the stage exchanged in the test (5.5.1, 5.5.2).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling.config import choices, key_of, typed_overrides
from supersampling.errors import UserError, first_line
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import trained_state
from supersampling.runs.identity import flat_parameters
from supersampling.runs.options import OPTION, described, restored

NOT_EXCHANGED = ("model.scale",)  # follows the task


@dataclass(frozen=True)
class Exchange:
    """The entries of a model that the command line exchanges, as it wrote them (``model/reproject=bilinear``), without
    those that are as stored, and the configuration of the exchanged model with class paths."""

    words: list[str]
    config: Mapping[str, Any]

    def name(self, trained: str) -> str:
        """Return the name of the exchanged model: ``dlctus, tested with reproject=bilinear``."""
        parts = " ".join(word.removeprefix("model/") for word in self.words)
        return f"{trained}, tested with {parts}" if parts else trained

    def build(self, source: str, **constants: float) -> Upsampler:
        """Return the exchanged model; raises `UserError` if its parts do not go together."""
        try:
            model: Upsampler = instantiate(dict(self.config), **constants)
        except InstantiationException as error:
            reason = first_line(error)
            raise UserError(f"{' '.join(self.words)} does not fit the model of {source} ({reason}).") from error
        return model

    def load_weights(self, model: Upsampler, checkpoint: Path, source: str) -> None:
        """Load the weights of a checkpoint; raises `UserError` unless all fit the model by name and shape."""
        trained = trained_state(checkpoint)
        exchanged = model.state_dict()
        names = [*exchanged, *(trained.keys() - exchanged.keys())]
        shapes = {name: (_shape(trained, name), _shape(exchanged, name)) for name in names}
        differing = [(name, *pair) for name, pair in shapes.items() if pair[0] != pair[1]]
        if differing:
            name, first, second = differing[0]
            more = f" (and {len(differing) - 1} more)" if len(differing) > 1 else ""
            raise UserError(
                f"{' '.join(self.words)} does not fit the weights of {source}: {name} is {first} there and {second} in "
                f"the exchanged model{more}: train that model, or exchange a stage that has the same weights."
            )
        model.load_state_dict(trained)

    def parameters(self, cfg: DictConfig, training: Mapping[str, Any]) -> dict[str, Any]:
        """Return the parameters of a training with those of the exchanged entries in place of its own."""
        paths = [key_of(word).replace("/", ".") for word in self.words]
        configured = flat_parameters(cfg, choices(), False)
        retained = {name: value for name, value in training.items() if not _belongs(name, paths)}
        return retained | {name: value for name, value in configured.items() if _belongs(name, paths)}


def exchange_of(cfg: DictConfig, stored: Mapping[str, Any], source: str) -> Exchange | None:
    """Return what the command line exchanges in a stored model, None if it names no part of a model.

    ``model=nsrd`` beside the parts is allowed if the stored model is one; its other parts remain the stored ones.

    Raises:
        UserError: the command line names another model, or a part that the stored model does not have.
    """
    words = [word for word in typed_overrides() if _is_part(key_of(word))]
    if not words:
        return None
    known = described(stored)
    selected = any(key_of(word) == "model" for word in typed_overrides())
    configured: Any = OmegaConf.to_container(cfg.model, resolve=True)
    option = described(configured)[OPTION]
    if selected and option != known[OPTION]:
        raise UserError(f"{source} holds {known[OPTION]}, but the command line has {option}: leave it out.")
    config = restored(known, source)
    exchanged = []
    for word in words:
        *parents, name = key_of(word).replace("/", ".").split(".")[1:]
        place, value = config, configured
        for parent in parents:
            place, value = place.get(parent, {}), value[parent]
        if name not in place:
            parts = ", ".join(sorted(str(key) for key, part in known.items() if isinstance(part, dict)))
            raise UserError(f"{source} holds {known[OPTION]}, which has no {key_of(word)}: exchange one of {parts}.")
        if described(place[name]) != described(value[name]):
            exchanged.append(word)
        place[name] = value[name]
    return Exchange(exchanged, config)


def _is_part(key: str) -> bool:
    return key.startswith(("model.", "model/")) and key not in NOT_EXCHANGED


def _belongs(name: str, paths: list[str]) -> bool:
    return any(name == path or name.startswith(f"{path}.") for path in paths)


def _shape(state: Mapping[str, Any], name: str) -> str:
    return "x".join(map(str, state[name].shape)) or "a number" if name in state else "missing"
