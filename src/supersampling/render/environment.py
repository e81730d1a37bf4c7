"""Inputs of every full-screen pass over surfaces: the sky, and the table of the BRDF's integral."""

import moderngl
import numpy as np

from supersampling.data.brdf_table import brdf_table
from supersampling.render.programs import assign
from supersampling.scenes.scene import Sky

_UNIT = 9  # the G-buffer and the shadow maps use the texture units up to 8


class Environment:
    """Sky and BRDF table; the table is uploaded on first use."""

    def __init__(self, ctx: moderngl.Context, sky: Sky) -> None:
        self._ctx, self._sky = ctx, sky
        self._table: moderngl.Texture | None = None

    def bind(self, program: moderngl.Program) -> None:
        sky = self._sky
        assign(program, sky_zenith=(*sky.zenith, sky.ambient), sky_horizon=sky.horizon, sky_ground=sky.ground)
        if "brdf_table" not in program:
            return
        if self._table is None:
            values = np.ascontiguousarray(brdf_table().numpy().transpose(1, 2, 0), dtype=np.float32)
            self._table = self._ctx.texture(values.shape[1::-1], 2, values.tobytes(), dtype="f4")
            self._table.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._table.repeat_x = self._table.repeat_y = False
        self._table.use(_UNIT)
        assign(program, brdf_table=_UNIT)
