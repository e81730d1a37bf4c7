"""Sheets of labelled pictures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from supersampling.show.drawings import FAINT, GROUND, INK, font
from supersampling.show.paint import Picture

_GAP = 12
_TITLE, _NOTE, _HEAD = 13, 11, 15
_LINE = 15
_NOTE_LINES = 2


@dataclass(frozen=True, eq=False)
class Panel:
    """A picture with its title and a note on its colours."""

    title: str
    note: str
    picture: Picture


@dataclass(frozen=True, eq=False)
class Section:
    title: str
    panels: Sequence[Panel]


def display_size(target: tuple[int, int], scale: int, width: int) -> tuple[int, int]:
    """Return the size of every picture of a sheet: that of the target, as near to ``width`` as integer factors allow.

    Small targets are enlarged by an integer; large ones are reduced by a divisor or a multiple of ``scale``, so that
    low-resolution pixels remain whole.
    """
    if target[0] <= width:
        return target[0] * (width // target[0]), target[1] * (width // target[0])
    minimum = -(-target[0] // width)
    divisors = [d for d in range(minimum, scale + 1) if scale % d == 0]
    reduction = divisors[0] if divisors else -(-minimum // scale) * scale
    return max(1, target[0] // reduction), max(1, target[1] // reduction)


def fit(picture: Picture, size: tuple[int, int]) -> Picture:
    """Return ``picture`` at ``size``: enlarged by repeating pixels, or reduced by averaging them."""
    larger = picture.shape[1] <= size[0]
    resampling = Image.Resampling.NEAREST if larger else Image.Resampling.BOX
    return np.asarray(Image.fromarray(picture).resize(size, resampling))


def compose(heading: str, sections: Sequence[Section], size: tuple[int, int], columns: int) -> Picture:
    """Return one picture of all sections, with ``columns`` panels per row, each at ``size``; both sides are even, for
    videos."""
    sections = [section for section in sections if section.panels]
    columns = max(1, min(columns, max((len(s.panels) for s in sections), default=1)))
    cell = size[1] + (1 + _NOTE_LINES) * _LINE + _GAP + 4
    rows = sum(-(-len(s.panels) // columns) for s in sections)
    heads = [s for s in sections if s.title]
    width = columns * (size[0] + _GAP) + _GAP
    height = 2 * _GAP + 2 * _LINE + rows * cell + len(heads) * 2 * _LINE
    image = Image.new("RGB", (width + width % 2, height + height % 2), GROUND)
    draw = ImageDraw.Draw(image)
    draw.text((_GAP, _GAP), _truncate(heading, width - 2 * _GAP, _HEAD, True), fill=INK, font=font(_HEAD, True))
    y = _GAP + 2 * _LINE
    for section in sections:
        if section.title:
            draw.text((_GAP, y), section.title, fill=FAINT, font=font(_TITLE, True))
            y += 2 * _LINE - 6
        for k, panel in enumerate(section.panels):
            x = _GAP + (k % columns) * (size[0] + _GAP)
            if k and k % columns == 0:
                y += cell
            _place(image, draw, panel, (x, y), size)
        y += cell
    return np.asarray(image)


def _place(
    image: Image.Image, draw: ImageDraw.ImageDraw, panel: Panel, position: tuple[int, int], size: tuple[int, int]
) -> None:
    x, y = position
    image.paste(Image.fromarray(fit(panel.picture, size)), (x, y))
    y += size[1] + 4
    draw.text((x, y), _truncate(panel.title, size[0], _TITLE, True), fill=INK, font=font(_TITLE, True))
    for k, line in enumerate(_wrap(panel.note, size[0])[:_NOTE_LINES]):
        draw.text((x, y + (k + 1) * _LINE), line, fill=FAINT, font=font(_NOTE))


def _wrap(text: str, width: int) -> list[str]:
    """Return lines that fit; a word that is wider than a line is truncated."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if font(_NOTE).getlength(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(_truncate(word, width, _NOTE, False))
    return [line for line in lines if line]


def _truncate(text: str, width: int, size: int, bold: bool) -> str:
    while len(text) > 1 and font(size, bold).getlength(text) > width:
        text = text[:-1]
    return text
