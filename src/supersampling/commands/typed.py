"""Settings that are text, whatever they look like."""

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from supersampling.errors import UserError


def as_typed(cfg: DictConfig, key: str) -> str | None:
    """The setting as the user typed it: Hydra reads ``3e7`` and ``95e41234``, both beginnings of ids, as numbers.

    Raises:
        UserError: a number that did not come from the command line, so that its text is unknown.
    """
    value = cfg[key]
    if value is None or isinstance(value, str):
        return value
    given = HydraConfig.get().overrides.task if HydraConfig.initialized() else []
    typed = [text for name, _, text in (str(o).partition("=") for o in given) if name.lstrip("+") == key]
    if not typed:
        raise UserError(f"{key}={value} was read as a number: put the text in quotes, {key}='\"...\"'")
    return typed[-1]
