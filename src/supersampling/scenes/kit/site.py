"""Places for parts in frames of their own: turned about y, then moved on the ground."""

from dataclasses import dataclass

from supersampling.scenes.kit.builder import Builder, Color
from supersampling.scenes.kit.shapes import Shape

WHITE: Color = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Site:
    """Local frame from which shapes are put into the builder; ``turn`` in degrees, ``x`` and ``z`` in metres."""

    builder: Builder
    turn: float
    x: float
    z: float

    def put(self, shape: Shape, material: int, color: Color = WHITE) -> None:
        self.builder.put(shape.turn_y(self.turn).shift(self.x, 0, self.z), material, color)
