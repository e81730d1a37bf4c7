"""Numbers in the XML files of the game's data."""

import math
from xml.etree.ElementTree import Element

from supersampling.errors import UserError

_LARGEST = 1e6  # of a coordinate in metres, a colour, a scale or an angle; tracks are a few kilometres long


def number(text: str, largest: float = _LARGEST) -> float:
    """Return the number of an attribute.

    Raises:
        UserError: The text is not a number, or the number is too large.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) <= largest:
        raise UserError(f"Invalid number {text[:40]} in the track's data: reinstall the SuperTuxKart data.")
    return value


def attribute(element: Element, name: str, default: float) -> float:
    """Return the number of an element's attribute, or ``default`` without it."""
    text = element.get(name)
    return default if text is None else number(text)


def index(text: str, count: int, what: str) -> int:
    """Return the index of one of ``count`` items.

    Raises:
        UserError: The text is not an index, or no such item exists.
    """
    if not text.strip().isdecimal() or int(text) >= count:
        raise UserError(f"The track's data refer to {what} {text[:40]} of {count}: reinstall the SuperTuxKart data.")
    return int(text)
