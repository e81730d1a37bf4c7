"""How an evaluation is made, beside its metrics: which frames and pixels count, and in how many bits."""

from dataclasses import replace
from typing import final

from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.prepare import Prepare
from supersampling.metrics.suite import Moment


@final
class Protocol:
    """Whole clips from the first frame on, the state carried.

    Args:
        prepare: quantisation.
        warm_up: frames at a clip's beginning that are made and listed, but enter no mean and no metric of clips.
        border: rendered pixels that are left out on every side of the image.

    Raises:
        UserError: a negative number.
    """

    def __init__(self, prepare: Prepare, warm_up: int = 0, border: int = 0) -> None:
        for name, value in (("warm_up", warm_up), ("border", border)):
            if value < 0:
                raise UserError(f"protocol.{name} must be 0 or more, got {value}; 0 leaves nothing out.")
        self.prepare = prepare
        self.warm_up = warm_up
        self._border = border

    def inner(self, moment: Moment) -> Moment:
        """A moment without its border; motion stays in units of the image that is left.

        Raises:
            UserError: nothing is left.
        """
        if self._border == 0:
            return moment
        assert moment.size is not None
        height, width = moment.size
        b = self._border
        if 2 * b >= min(height, width):
            raise UserError(
                f"protocol.border={b} leaves nothing of frames that were rendered at {width}x{height}: choose less."
            )
        scale = moment.target.shape[-1] // width

        def cut(pair: tuple[Tensor, Tensor] | None) -> tuple[Tensor, Tensor] | None:
            return None if pair is None else (_cut(pair[0], b * scale), _cut(pair[1], b * scale))

        def vectors(motion: Tensor | None) -> Tensor | None:
            if motion is None:
                return None
            whole = motion.new_tensor((width / (width - 2 * b), height / (height - 2 * b)))
            return _cut(motion, b) * whole[:, None, None]

        return replace(
            moment,
            output=_cut(moment.output, b * scale),
            target=_cut(moment.target, b * scale),
            previous=cut(moment.previous),
            motion=vectors(moment.motion),
            motion_dual=vectors(moment.motion_dual),
            radiance=cut(moment.radiance),
            size=(height - 2 * b, width - 2 * b),
        )


def _cut(image: Tensor, pixels: int) -> Tensor:
    return image[..., pixels:-pixels, pixels:-pixels]
