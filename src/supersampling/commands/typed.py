"""Settings that are text even if they look like numbers."""

from omegaconf import DictConfig

from supersampling.config import key_of, typed_overrides
from supersampling.errors import UserError


def as_typed(cfg: DictConfig, key: str) -> str | None:
    """Return the setting as the user typed it: Hydra reads ids such as ``3e7`` and ``95e41234`` as numbers.

    Raises:
        UserError: a number that did not come from the command line, so that its text is unknown.
    """
    value = cfg[key]
    if value is None or isinstance(value, str):
        return value
    texts = [override.partition("=")[2] for override in typed_overrides() if key_of(override) == key]
    if not texts:
        raise UserError(f"{key}={value} was read as a number: put the text in quotes, {key}='\"...\"'.")
    return texts[-1]
