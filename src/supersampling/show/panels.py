"""The panels of one frame: all its buffers, and images that are derived from them."""

from collections.abc import Callable

import numpy as np

from supersampling.frames import BUFFERS, Kind
from supersampling.show import drawings, paint
from supersampling.show.checks import MASK_THRESHOLD, check_warp, disoccluded, gradient_energy, read_lighting
from supersampling.show.clip import Array, ClipView
from supersampling.show.paint import Picture
from supersampling.show.scales import Scales, error_scale, exposure, in_pixels
from supersampling.show.sheet import Panel, Section

Styled = tuple[Picture, str]
Style = Callable[[Array, ClipView, Scales], Styled]


def _light(values: Array, clip: ClipView, scales: Scales) -> Styled:
    return paint.light(values, scales.stops), f"{span(values)}, tonemapped at {_times(scales.stops)} exposure"


def _motion(values: Array, clip: ClipView, scales: Scales) -> Styled:
    pixels = in_pixels(clip, values)
    longest = float(np.hypot(*pixels).max())
    return paint.motion(pixels, scales.motion), f"up to {longest:.3g} px; full colour at {scales.motion:g} px"


def _depth(values: Array, clip: ClipView, scales: Scales) -> Styled:
    surfaces = values[values < 1.0]
    note = f"{span(surfaces)}, near is yellow, sky black" if surfaces.size else "only sky"
    return paint.depth(values, scales.nearest, scales.farthest), note


def _ids(values: Array, clip: ClipView, scales: Scales) -> Styled:
    shown = np.unique(values[values > 0])
    if shown.size < 2:
        return paint.ids(values), f"only object {shown[0]:.0f}" if shown.size else "only sky"
    return paint.ids(values), f"{shown.size} objects, numbers {shown[0]:.0f} to {shown[-1]:.0f}"


# The style of each kind of buffer; depth has a separate colour map.
_STYLES: dict[Kind, Style] = {
    "display": lambda values, *_: (paint.colour(values), f"{span(values)}, as it is"),
    "light": _light,
    "reflectance": lambda values, *_: (paint.reflectance(values), f"{span(values)}, sRGB curve"),
    "plane": _motion,
    "direction": lambda values, *_: (paint.normal(values), f"{span(values)}, shown as 0.5 + 0.5 n"),
    "scalar": lambda values, *_: (paint.grey(values), f"{span(values)}, black 0, white 1"),
    "id": _ids,
}


# As in `BUFFERS`, except that the two kinds of motion vectors are side by side.
_ORDER = list(BUFFERS)
_ORDER.remove("motion_dual")
_ORDER.insert(_ORDER.index("motion") + 1, "motion_dual")


def span(values: Array) -> str:
    """Return the range of the values in words."""
    if values.min() == values.max():
        return f"all {float(values.min()):.3g}"
    return f"{float(values.min()):.3g} to {float(values.max()):.3g}"


def _times(stops: int) -> str:
    return f"{2.0**stops:g}x"


def _finite(title: str, values: Array, style: Callable[[Array], Styled]) -> Panel:
    """Return a panel in which NaN and infinite pixels are highlighted and counted."""
    broken = ~np.isfinite(values).all(axis=0)
    picture, note = style(np.where(np.isfinite(values), values, np.float32(0.0)) if broken.any() else values)
    if broken.any():
        picture = picture.copy()
        picture[broken] = paint.BROKEN
        note = f"{int(broken.sum())} pixels are not finite (magenta); {note}"
    return Panel(title, note, picture)


def buffer_panel(clip: ClipView, frame: int, name: str, scales: Scales) -> Panel:
    """Return the panel of an image buffer."""
    style = _depth if name.endswith("depth") else _STYLES[BUFFERS[name].kind]
    return _finite(name, clip.read(name, frame), lambda values: style(values, clip, scales))


def jitter_panel(clip: ClipView, frame: int, size: tuple[int, int]) -> Panel:
    """Return the panel of the sample positions in a pixel: that of this frame and those of earlier frames."""
    positions = np.stack([clip.read("jitter", t) for t in range(frame + 1)])
    x, y = positions[-1]
    note = f"({x:+.3f}, {y:+.3f}) of [-0.5, 0.5), orange; earlier frames grey"
    return Panel("jitter", note, drawings.jitter(size, positions, clip.file.spec.scale))


def wheel_panel(scales: Scales, size: tuple[int, int]) -> Panel:
    note = f"towards the previous position; edge: {scales.motion:g} low-resolution px"
    return Panel("motion's colours", note, drawings.wheel(size, scales.motion))


def lighting_panel(clip: ClipView, frame: int) -> list[Panel]:
    """Return the panel of demodulated lighting, if the file has the necessary buffers."""
    values = read_lighting(clip, frame)
    if values is None:
        return []
    stops = exposure(values)
    surface = gradient_energy(clip.read("radiance", frame) - clip.read("emission", frame))
    ratio = f"{gradient_energy(values) / surface:.2g}" if surface > 0.0 else "-"
    note = f"at {_times(stops)} exposure; gradient energy {ratio} of radiance's"
    return [_finite("lighting", values, lambda v: (paint.light(v, stops), f"{span(v)}, {note}"))]


def warp_panels(clip: ClipView, frame: int, full: float | None = None) -> list[Panel]:
    """Return the panels of the warp check if it exists: errors with and without the warp, bright at ``full``."""
    check = check_warp(clip, frame)
    if check is None:
        return []
    full = full or error_scale(check.still_error)
    scale = f"bright at {255 * full:.0f}/255"
    return [
        Panel("previous target, warped", "carried to this frame by its motion vectors", paint.colour(check.warped)),
        Panel(
            "|warped - target|",
            f"mean {255 * check.mean:.2f}/255; {scale}; blue: out of the previous image",
            paint.difference(check.error, full, check.inside),
        ),
        Panel(
            "|previous - target|",
            f"mean {255 * check.still_mean:.2f}/255 without the warp; {scale}",
            paint.difference(check.still_error, full, check.inside),
        ),
    ]


def mask_panel(clip: ClipView, frame: int) -> list[Panel]:
    """Return the panel of disocclusions over the colour, if both kinds of motion vectors exist."""
    if not (clip.has("motion", frame) and clip.has("motion_dual", frame)):
        return []
    mask = disoccluded(clip.read("motion", frame), clip.read("motion_dual", frame))
    background = (
        paint.colour(clip.read("color", frame))
        if clip.has("color", frame)
        else np.full((*mask.shape, 3), 128, dtype=np.uint8)
    )
    note = f"{100 * mask.mean():.1f}% in red: |motion_dual - motion| of at least {MASK_THRESHOLD:g} px"
    return [Panel("disocclusion mask", note, paint.masked(background, mask))]


def sections(clip: ClipView, frame: int, size: tuple[int, int]) -> list[Section]:
    """Return all panels of a frame, for pictures that are shown at ``size``."""
    scales = Scales.measure(clip, frame)
    names = [name for name in _ORDER if clip.has(name, frame)]
    low = [buffer_panel(clip, frame, n, scales) for n in names if BUFFERS[n].resolution == "low"]
    high = [buffer_panel(clip, frame, n, scales) for n in names if BUFFERS[n].resolution == "high"]
    if "jitter" in names:
        low.append(jitter_panel(clip, frame, size))
    if any(BUFFERS[n].kind == "plane" and BUFFERS[n].resolution != "frame" for n in names):
        low.append(wheel_panel(scales, size))
    derived = [*lighting_panel(clip, frame), *mask_panel(clip, frame), *warp_panels(clip, frame)]
    (width, height), (low_width, low_height) = clip.size, clip.low_size
    return [
        Section(f"Input, {low_width} x {low_height}, one sample per pixel", low),
        Section(f"Target resolution, {width} x {height}", high),
        Section("Derived", derived),
    ]
