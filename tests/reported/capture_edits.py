"""Random edits of captures: what people, archives, locales and recorders do to files, metadata and buffers."""

import json
import random
import shutil
from collections.abc import Callable, Sequence
from enum import Enum
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

from supersampling.data.exporters.images import write_exr


class Effect(Enum):
    """What an import of the edited capture may do besides refusing it in a sentence."""

    NONE = "import the same values"
    NAMED = "import other values and print a line that an unedited capture does not give"
    UNKNOWN = "import other values, since nothing in the capture contradicts them"


Edit = Callable[[Path, random.Random], Effect]
NUMBERS = (0, -1, 1, 0.3, 1e-12, 1e300, -1e300, 10**400, float("nan"), float("inf"))
OTHERS = ("0,25", "", None, True, [], {}, [[]], "\u0661")


def images(root: Path) -> list[Path]:
    return sorted(p for p in root.rglob("*") if p.suffix in (".exr", ".png") and p.stem.isdigit())


def documents(root: Path) -> list[Path]:
    return sorted(root.rglob("*.json"))


def streams(root: Path) -> list[Path]:
    return sorted({path.parent for path in images(root)})


def remove(root: Path, rng: random.Random) -> Effect:
    rng.choice(images(root) + documents(root)).unlink()
    return Effect.NAMED


def remove_stream(root: Path, rng: random.Random) -> Effect:
    shutil.rmtree(rng.choice(streams(root)))
    return Effect.NAMED


def truncate(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root) + documents(root))
    path.write_bytes(path.read_bytes()[: rng.randrange(path.stat().st_size)])
    return Effect.NONE


def flip_byte(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root) + documents(root))
    content = bytearray(path.read_bytes())
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    path.write_bytes(content)
    return Effect.UNKNOWN


def become_folder(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root) + documents(root))
    path.unlink()
    path.mkdir()
    return Effect.NONE


def renumber(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root))
    path.rename(path.with_stem(str(rng.choice((9, 10**20)))))
    return Effect.NONE


def duplicate(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root))
    shutil.copy(path, path.with_stem("000" + path.stem))
    return Effect.NONE


def pad(root: Path, rng: random.Random) -> Effect:
    for path in images(rng.choice(streams(root))):
        path.rename(path.with_stem(path.stem.zfill(rng.randrange(1, 7))))
    return Effect.NONE


def shout(root: Path, rng: random.Random) -> Effect:
    for path in images(rng.choice(streams(root))):
        path.rename(path.with_suffix(path.suffix.upper()))
    return Effect.NONE


def litter(root: Path, rng: random.Random) -> Effect:
    path = rng.choice(images(root))
    for folder in (path.parent, path.parent.parent):
        (folder / f"._{path.name}").write_bytes(b"\0\5\26\7")
        (folder / "Thumbs.db").write_bytes(b"\0")
        (folder / ".ipynb_checkpoints").mkdir(exist_ok=True)
    (root / "__MACOSX").mkdir(exist_ok=True)
    return Effect.NONE


def swap(root: Path, rng: random.Random) -> Effect:
    """Exchange two frames of a stream, of the same clip or of two clips."""
    first = rng.choice(images(root))
    second = rng.choice([p for p in images(root) if p.parent.parent == first.parent.parent])
    content = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(content)
    # Depth, normals and light of another frame may be those of this one as well, and so may its motion but for edges.
    known = any(name in str(first).lower() for name in ("enhanced", "view_png", "ground_truth"))
    return Effect.NAMED if known and first.parent == second.parent else Effect.UNKNOWN


def rewrite_document(root: Path, rng: random.Random) -> Effect:
    """Write a document as other programs do; only the first two are JSON in UTF-8."""
    paths = documents(root)
    if paths:
        path = rng.choice(paths)
        text = path.read_text()
        forms = ("\ufeff" + text, text.replace(",", ",\r\n"), text.replace("}", ",}"), text.replace(".", ","), text[1:])
        form = rng.randrange(len(forms) + 1)
        path.write_bytes(text.encode("utf-16") if form == len(forms) else forms[form].encode())
    return Effect.NONE


def edit_document(root: Path, rng: random.Random) -> Effect:
    """Replace, delete or repeat a value."""
    paths = documents(root)
    if paths:
        path = rng.choice(paths)
        content = json.loads(path.read_text())
        parent, key = rng.choice(list(places(content)))
        if rng.random() < 0.3:
            del parent[key]
        else:
            parent[key] = rng.choice(NUMBERS + OTHERS)
        path.write_text(json.dumps(content))
    # Jitter of a single frame, sizes, versions and cuts are believed.
    return Effect.UNKNOWN


def places(content: object) -> Sequence[tuple[dict | list, object]]:
    """Return the container and the key of each value of a JSON."""
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    return [place for key, value in items for place in [(content, key), *places(value)]]


CHANGES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "zero": np.zeros_like,
    "half": lambda image: image // 2 if image.dtype == np.uint8 else image * image.dtype.type(0.5),
    "negative": lambda image: 255 - image if image.dtype == np.uint8 else -image,
    "upside down": lambda image: image[::-1],
    "transposed": lambda image: image.swapaxes(0, 1),
    "small": lambda image: image[::2, ::2],
    "one": np.ones_like,
    "infinite": lambda image: image if image.dtype == np.uint8 else np.full_like(image, np.inf),
    "huge": lambda image: image if image.dtype == np.uint8 else np.full_like(image, 60000.0),
}


def change_values(root: Path, rng: random.Random) -> Effect:
    """Change the values of a kind of buffer in all clips, as a recorder with a fault does."""
    kind = rng.choice(sorted({(path.parent.parent, path.suffix) for path in images(root)}))
    change = CHANGES[rng.choice(sorted(CHANGES))]
    for path in sorted(kind[0].rglob(f"*{kind[1]}")):
        rewrite(path, change)
    return Effect.NAMED


def change_frame(root: Path, rng: random.Random) -> Effect:
    rewrite(rng.choice(images(root)), CHANGES[rng.choice(sorted(CHANGES))])
    return Effect.UNKNOWN


def rewrite(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    if path.suffix == ".png":
        Image.fromarray(np.ascontiguousarray(change(np.asarray(Image.open(path))))).save(path)
        return
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    names = "".join(sorted(channels, key="RGBXYZ".index))
    image = change(np.stack([channels[name].pixels for name in names], axis=-1))
    write_exr(path, image, names, half=image.dtype == np.float16 and bool(np.isfinite(image).all()))


EDITS: tuple[Edit, ...] = (
    *(remove, remove_stream, truncate, flip_byte, become_folder, renumber, duplicate, pad, shout, litter, swap),
    *(rewrite_document, edit_document, edit_document, change_values, change_values, change_values, change_frame),
)


def edit_capture(root: Path, rng: random.Random) -> tuple[list[str], set[Effect]]:
    """Apply one or two edits; return their names and effects."""
    names, effects = [], set()
    for edit in rng.sample(EDITS, rng.choice((1, 1, 2))):
        try:
            effects.add(edit(root, rng))
            names.append(edit.__name__)
        # The second edit may meet a file that the first one broke.
        except (OSError, ValueError, IndexError, RuntimeError, TypeError):
            if not names:
                raise
            effects.add(Effect.UNKNOWN)
    return names, effects
