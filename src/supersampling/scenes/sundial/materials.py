"""Materials of the sundial: all are dull, none is cut out or glows."""

import numpy as np

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.textures import Maps, wood
from supersampling.scenes.scene import Material
from supersampling.scenes.sundial import textures as paint


class Palette:
    """Materials of the sundial, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        oak = [(0.2, 0.12, 0.07), (0.42, 0.27, 0.16), (0.58, 0.42, 0.26)]
        self.lime = self._add("lime wash", paint.wall(512, 1), 2.6)
        self.bays = [self._add(f"painted bay {k}", paint.arcade(768, 10 + k, k), 1.0) for k in range(2)]
        self.dado = self._add("wall tiles", paint.glazed_dado(512, 3), 0.92)
        self.frieze = self._add("frieze", paint.meander(256, 4), 1.0)
        self.paving = self._add("paving", paint.paving(768, 5), 3.2)
        self.stucco = self._add("stencilled stucco", paint.stucco(512, 6), 1.8)
        self.wood = self._add("oak", wood(512, 7, oak), 1.0)

    def _add(self, name: str, maps: Maps, tile: float) -> int:
        albedo, normal, rough = maps
        matte = np.maximum(rough, np.array((150, 0, 255), np.uint8))
        double_sided = name == "lime wash"  # the cloths and the lamp's shade, which are single sheets
        material = Material(name, albedo, normal, matte, roughness=1.0, metallic=0.0, double_sided=double_sided)
        return self._builder.material(material, tile)
