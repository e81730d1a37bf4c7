"""The specification of a data set file: all that determines the content of its buffers, whichever of them it holds."""

import hashlib
import json
from dataclasses import asdict, dataclass

SCHEMA_VERSION = 3
SPLITS = ("train", "val", "test")


@dataclass(frozen=True, kw_only=True)
class CaptureSpec:
    """The specification of one file: one scene, one split.

    ``frame`` is the whole target frame ``(width, height)`` in pixels, ``window`` the part that each clip stores (equal
    to ``frame`` for whole frames), both before rounding down to a multiple of ``scale``. The last ``targets`` frames of
    a clip have the high-resolution buffers, of ``samples x samples`` samples per pixel. ``jitter``, ``mip_bias`` and
    ``camera`` are named settings (`supersampling.render.jitter`, `supersampling.render.paths`), ``recorded`` for an
    imported capture; ``candidates`` seeded takes are proposed for each clip. ``origin`` identifies imported captures
    and is empty for renders.
    """

    scene: str
    split: str
    clips: int
    frames: int
    targets: int
    frame: tuple[int, int]
    window: tuple[int, int]
    scale: int
    jitter: str
    mip_bias: str
    samples: int
    seed: int
    candidates: int
    camera: str = "walk"
    origin: str = ""

    @property
    def target_size(self) -> tuple[int, int]:
        """Return ``(width, height)`` of the stored target."""
        width, height = self.window
        return width // self.scale * self.scale, height // self.scale * self.scale

    def to_json(self) -> str:
        return json.dumps({"schema": SCHEMA_VERSION, **asdict(self)}, sort_keys=True)

    @property
    def file_name(self) -> str:
        """Return a readable name that is unique to the specification."""
        digest = hashlib.sha256(self.to_json().encode()).hexdigest()[:8]
        plain = "".join(c if c.isalnum() or c in "-." else "_" for c in self.scene).strip("_.")
        return f"{plain}_{self.split}_x{self.scale}_{digest}.h5"
