"""The protocol of an evaluation: the frames and pixels that count, and the quantisation."""

from dataclasses import replace
from typing import final

from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.prepare import Prepare


@final
class Protocol:
    """Evaluation on whole clips from the first frame on, with the state carried from frame to frame.

    Args:
        prepare: quantisation.
        warm_up: the number of frames at the beginning of a clip that are computed and listed, but enter neither means
            nor metrics of clips.
        border: rendered pixels to leave out on every side of the image.

    Raises:
        UserError: a number is negative.
    """

    def __init__(self, prepare: Prepare, warm_up: int = 0, border: int = 0) -> None:
        for name, value in (("warm_up", warm_up), ("border", border)):
            if value < 0:
                raise UserError(f"Invalid protocol.{name}={value}: use at least 0, which leaves nothing out.")
        self.prepare = prepare
        self.warm_up = warm_up
        self._border = border

    def inner(self, moment: Moment) -> Moment:
        """Return a moment without its border; motion is in units of the remaining image.

        Raises:
            UserError: no pixel remains.
        """
        if self._border == 0:
            return moment
        assert moment.size is not None
        height, width = moment.size
        b = self._border
        if 2 * b >= min(height, width):
            raise UserError(f"Invalid protocol.border={b}: use less than half of the rendered {width}x{height} pixels.")
        scale = moment.target.shape[-1] // width

        def crop_pair(pair: tuple[Tensor, Tensor] | None) -> tuple[Tensor, Tensor] | None:
            return None if pair is None else (_crop(pair[0], b * scale), _crop(pair[1], b * scale))

        def crop_motion(motion: Tensor | None) -> Tensor | None:
            if motion is None:
                return None
            factors = motion.new_tensor((width / (width - 2 * b), height / (height - 2 * b)))
            return _crop(motion, b) * factors[:, None, None]

        return replace(
            moment,
            output=_crop(moment.output, b * scale),
            target=_crop(moment.target, b * scale),
            previous=crop_pair(moment.previous),
            motion=crop_motion(moment.motion),
            motion_dual=crop_motion(moment.motion_dual),
            radiance=crop_pair(moment.radiance),
            size=(height - 2 * b, width - 2 * b),
        )


def _crop(image: Tensor, pixels: int) -> Tensor:
    return image[..., pixels:-pixels, pixels:-pixels]
