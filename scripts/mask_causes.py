"""Disoccluded pixels that the mask of dual motion vectors misses, by cause, on seeded frames of scenes.

python scripts/mask_causes.py foundry stk/cocoa_temple             a table of pixels
python scripts/mask_causes.py stk/cocoa_temple --bias 0 --finer 3  against a truth with textures of three levels below
python scripts/mask_causes.py stk/cocoa_temple --picture FILE      and a picture of the frame that has most of them
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from supersampling.errors import UserError
from supersampling.render.camera import Shot
from supersampling.render.measure.disocclusion import CAUSES, MIP_BIAS, SCALE, Disocclusion, disocclusion
from supersampling.render.measure.probe import Probe, backwards, seeded_shots
from supersampling.render.measure.scene import SHOTS
from supersampling.scenes.load import load_scene

VEILED = "also hidden in the current frame, so not disoccluded"
MEANINGS = {"veiled": VEILED, **CAUSES}
COLOURS = {
    "veiled": (70, 90, 200),
    "marked": (60, 190, 90),
    "beside": (170, 225, 150),
    "together": (20, 20, 20),
    "parallel": (240, 150, 40),
    "depth": (200, 60, 220),
    "sample": (235, 40, 50),
}
CROP = (160, 90)  # low-resolution pixels
ZOOM = 4
TEXT = 20  # height of a panel's title, pixels


def pixels(measured: Disocclusion) -> dict[str, np.ndarray]:
    """Return the masks ``(h, w)`` of all `MEANINGS`."""
    return {"veiled": measured.veiled, **{name: measured.cause == k for k, name in enumerate(CAUSES, start=1)}}


def table(name: str, counts: dict[str, int]) -> str:
    """Return one line per meaning: pixels, and the share of the disoccluded ones."""
    total = sum(count for key, count in counts.items() if key != "veiled")
    lines = [f"{name}: {total} disoccluded pixels"]
    for key, meaning in MEANINGS.items():
        share = "" if key == "veiled" or not total else f"{counts[key] / total:.1%}"
        lines.append(f"  {key:8} {counts[key]:7} {share:>6}  {meaning}")
    return "\n".join(lines)


def picture(probe: Probe, shot: Shot, file: Path) -> None:
    """Draw the low-resolution frames, and the causes against a truth at finer textures and at the frame's own."""
    frames = [
        probe.renderer.low(moment, SCALE, (0.0, 0.0), MIP_BIAS, frozenset({"color"}))["color"]
        for moment in (backwards(shot), shot)
    ]
    level, finer = disocclusion(probe, shot), disocclusion(probe, shot, 0.0, 3.0)
    box = densest(level.cause > 1)
    panels = {
        "previous frame": display(frames[0]),
        "current frame": display(frames[1]),
        "truth with finer textures than the frame": paint(frames[1], finer),
        "truth with the frame's own textures": paint(frames[1], level),
    }
    width, height = CROP[0] * ZOOM, CROP[1] * ZOOM
    sheet = Image.new("RGB", (2 * width, 2 * (height + TEXT) + TEXT), "white")
    draw = ImageDraw.Draw(sheet)
    for k, (title, image) in enumerate(panels.items()):
        x, y = (k % 2) * width, (k // 2) * (height + TEXT)
        sheet.paste(Image.fromarray(image).crop(box).resize((width, height), Image.Resampling.NEAREST), (x, y + TEXT))
        draw.text((x + 6, y + TEXT / 2), title, fill="black", anchor="lm", font_size=15)
    step = 2 * width / len(COLOURS)
    for k, (key, colour) in enumerate(COLOURS.items()):
        y = sheet.height - TEXT
        draw.rectangle((k * step + 6, y + 4, k * step + 18, y + 16), fill=colour)
        draw.text((k * step + 24, y + TEXT / 2), key, fill="black", anchor="lm", font_size=15)
    sheet.save(file, optimize=True, quality=85)


def display(color: np.ndarray) -> np.ndarray:
    return np.round(255.0 * color.clip(0.0, 1.0)).astype(np.uint8)


def paint(color: np.ndarray, measured: Disocclusion) -> np.ndarray:
    """Return a pale grey frame with the pixels of each meaning in its colour."""
    image = display(np.repeat(0.6 + 0.4 * color.mean(axis=-1, keepdims=True), 3, axis=-1))
    for key, mask in pixels(measured).items():
        image[mask] = COLOURS[key]
    return image


def densest(mask: np.ndarray) -> tuple[int, int, int, int]:
    """Return the crop (left, top, right, bottom) that has most pixels of the mask."""
    width, height = CROP
    summed = np.pad(mask.astype(int).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    inner = summed[height:, width:] - summed[:-height, width:] - summed[height:, :-width] + summed[:-height, :-width]
    top, left = (int(k) for k in np.unravel_index(int(inner.argmax()), inner.shape))
    return left, top, left + width, top + height


def examine(name: str, shots: int, bias: float, finer: float, file: Path | None) -> None:
    scene = load_scene(name)
    counts = dict.fromkeys(MEANINGS, 0)
    fullest: tuple[int, Shot] | None = None
    with Probe(scene) as probe:
        for shot in seeded_shots(scene, shots):
            measured = disocclusion(probe, shot, bias, finer)
            for key, mask in pixels(measured).items():
                counts[key] += int(mask.sum())
            total = int(measured.certain.sum())
            fullest = (total, shot) if fullest is None or total > fullest[0] else fullest
        print(table(name, counts))
        if file is not None and fullest is not None:
            picture(probe, fullest[1], file)
            print(scene.attribution)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Causes of what the mask of dual motion vectors misses.")
    parser.add_argument("scenes", nargs="+", metavar="SCENE", help="built-in scenes and stk/<track>")
    parser.add_argument("--shots", type=int, default=SHOTS, help="frames per scene (default: %(default)s)")
    parser.add_argument("--bias", type=float, default=MIP_BIAS, help="mip bias of the frames (default: %(default)s)")
    parser.add_argument("--finer", type=float, default=0.0, help="levels by which textures of the truth are finer")
    parser.add_argument("--picture", type=Path, help="file of a picture of the last scene")
    options = parser.parse_args(arguments)
    try:
        for name in options.scenes:
            last = name == options.scenes[-1]
            examine(name, options.shots, options.bias, options.finer, options.picture if last else None)
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
