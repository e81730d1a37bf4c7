"""The specification of a data set file: all that determines the content of its buffers, whichever of them it holds."""

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields
from typing import Any

SCHEMA_VERSION = 3
SPLITS = ("train", "val", "test")

# Jitter patterns whose positions have changed since they were first rendered, by name and scale. A file of a former
# revision has another name and fingerprint, so that it is never taken for a file of today's.
JITTER_REVISIONS = {("thesis", 4): 1, ("thesis", 2): 1}  # 0: our own order; 1: that of the thesis's program


@dataclass(frozen=True, kw_only=True)
class CaptureSpec:
    """The specification of one file: one scene, one split.

    ``frame`` is the whole target frame ``(width, height)`` in pixels, ``window`` the part that each clip stores (equal
    to ``frame`` for whole frames), both before rounding down to a multiple of ``scale``. The last ``targets`` frames of
    a clip have the high-resolution buffers, of ``samples x samples`` samples per pixel. ``jitter``, ``mip_bias`` and
    ``camera`` are named settings (`supersampling.render.jitter`, `supersampling.render.paths`), ``recorded`` for an
    imported capture; ``candidates`` seeded takes are proposed for each clip. ``origin`` identifies imported captures
    and is empty for renders. ``jitter_revision`` is that of `JITTER_REVISIONS`, or of the file that it was read from.
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
    jitter_revision: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "jitter_revision", JITTER_REVISIONS.get((self.jitter, self.scale), 0))

    @property
    def target_size(self) -> tuple[int, int]:
        """Return ``(width, height)`` of the stored target."""
        width, height = self.window
        return width // self.scale * self.scale, height // self.scale * self.scale

    def to_json(self) -> str:
        values = {"schema": SCHEMA_VERSION, **asdict(self)}
        if self.jitter_revision == 0:  # files from before there were revisions keep their names
            del values["jitter_revision"]
        return json.dumps(values, sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> "CaptureSpec":
        """Return the specification that `to_json` wrote.

        Raises:
            ValueError: it has another schema, fields that are missing or unknown, or values that no file can have.
        """
        values = json.loads(text)
        schema = values.pop("schema", None) if isinstance(values, dict) else None
        if schema != SCHEMA_VERSION:
            raise ValueError(f"schema {schema} instead of {SCHEMA_VERSION}")
        kinds = {item.name: item.type for item in fields(cls)}
        invalid = sorted(key for key, value in values.items() if not _fits(kinds.get(key), value))
        if invalid:
            raise ValueError(f"{invalid[0]}={values[invalid[0]]}")
        try:
            arguments: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
            revision = arguments.pop("jitter_revision", 0)
            spec = cls(**arguments)
        except TypeError as error:
            raise ValueError("a missing field") from error
        if not (spec.clips >= 1 and 1 <= spec.targets <= spec.frames and 1 <= spec.scale <= min(spec.window)):
            raise ValueError("impossible sizes")
        object.__setattr__(spec, "jitter_revision", revision)
        return spec

    @property
    def file_name(self) -> str:
        """Return a readable name that is unique to the specification."""
        digest = hashlib.sha256(self.to_json().encode()).hexdigest()[:8]
        plain = "".join(c if c.isalnum() or c in "-." else "_" for c in self.scene).strip("_.")
        return f"{plain}_{self.split}_x{self.scale}_{digest}.h5"


def _fits(kind: Any, value: Any) -> bool:
    """Return whether a JSON value has the type of a field; pairs are lists in JSON."""
    if kind in (int, str):
        return type(value) is kind
    return isinstance(value, list) and [type(side) for side in value] == [int, int]
