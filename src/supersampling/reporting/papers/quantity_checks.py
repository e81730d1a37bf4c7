"""Checks of the quantity that a claim is about, and of how large its difference must be."""

from supersampling.errors import UserError
from supersampling.reporting.papers.schema import Claim


def check_quantity(claim: Claim, place: str) -> None:
    """Raise `UserError` unless the claim's metric and kind allow its frames, factor, percent or smallest difference."""
    if claim.over_frames and (claim.exact or (claim.frames is not None and claim.settles is not None)):
        raise UserError(
            f"{place}: Invalid frames={claim.frames} or settles={claim.settles} of metric={claim.metric}: use one of "
            "them, of a metric that frames have."
        )
    if claim.frames is not None and not (len(claim.frames) == 2 and 0 <= claim.frames[0] <= claim.frames[1]):
        raise UserError(f"{place}: Invalid frames={claim.frames}: use the first and the last frame, from 0.")
    if claim.settles is not None and claim.settles <= 0:
        raise UserError(f"{place}: Invalid settles={claim.settles:g}: use a positive distance.")
    if claim.relative and not claim.exact:
        raise UserError(f"{place}: Invalid metric={claim.metric} of relative: use a run: or benchmark: metric.")
    if claim.times != 1.0 and not (claim.times > 1.0 and claim.kind == "less" and not claim.relative):
        raise UserError(
            f"{place}: Invalid times={claim.times:g} of kind={claim.kind}: use a factor above 1, of kind less and not "
            "in percent."
        )
    if claim.at_least and (claim.kind not in ("more", "less") or claim.times != 1.0):
        raise UserError(
            f"{place}: Invalid at_least={claim.at_least:g} of kind={claim.kind}: use it of kind more or less, without "
            "times."
        )
    if claim.at_least and claim.published is not None and not _exceeds(claim, claim.published):
        raise UserError(
            f"{place}: Invalid at_least={claim.at_least:g}: use less than the published={claim.published:g}, in the "
            f"direction of kind={claim.kind}."
        )


def _exceeds(claim: Claim, difference: float) -> bool:
    return (difference if claim.kind == "more" else -difference) >= claim.at_least
