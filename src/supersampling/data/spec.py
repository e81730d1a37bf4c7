"""What a data set file holds: everything that decides its content, so that equal specifications give equal files."""

import hashlib
import json
from dataclasses import asdict, dataclass

SCHEMA_VERSION = 2
SPLITS = ("train", "val", "test")


@dataclass(frozen=True)
class CaptureSpec:
    """One file: one scene, one split.

    ``frame`` is the whole target frame ``(width, height)`` in pixels, ``window`` the part that each clip keeps (equal to
    ``frame`` for whole frames), both before they are rounded down to a multiple of ``scale``. The last ``targets`` frames of
    a clip have a target, of ``samples x samples`` a pixel. ``jitter`` and ``mip_bias`` are named settings
    (`supersampling.render.jitter`); ``candidates`` seeded takes are proposed for each clip.
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

    @property
    def target_size(self) -> tuple[int, int]:
        """Stored target ``(width, height)``."""
        width, height = self.window
        return width // self.scale * self.scale, height // self.scale * self.scale

    def to_json(self) -> str:
        return json.dumps({"schema": SCHEMA_VERSION, **asdict(self)}, sort_keys=True)

    @property
    def file_name(self) -> str:
        """A readable name that differs between any two specifications."""
        digest = hashlib.sha256(self.to_json().encode()).hexdigest()[:8]
        return f"{self.scene.replace('/', '_')}_{self.split}_x{self.scale}_{digest}.h5"
