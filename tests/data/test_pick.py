import numpy as np
import pytest

from supersampling.data.pick import ClipWindow, MostEdges, Uniform, motion_edges
from supersampling.errors import UserError

PLACES = [ClipWindow(file=0, clip=clip, stop=8, x=0, y=0) for clip in range(6)]


def motion(place):
    """Two halves that part; clip 3 the fastest, in every other frame."""
    field = np.zeros((2, 4, 6, 2))
    field[0, :, 3:, 0] = 1.0 if place.clip == 3 else 0.1 * place.clip
    return field


def proposals():
    places = iter(PLACES)
    return lambda: next(places)


def test_edges_are_counted_where_neighbours_differ():
    # One of the five steps along x in every row of one of the two frames; none of those along y.
    assert motion_edges(motion(PLACES[3])) == pytest.approx((0.5 / 5 + 0.0) / 2)
    assert motion_edges(motion(PLACES[4])) == 0.0  # 0.4 pixels are no edge


def test_first_proposal_or_most_edges():
    assert Uniform()(proposals(), motion) == PLACES[0]
    assert MostEdges(6)(proposals(), motion) == PLACES[3]
    assert MostEdges(3)(proposals(), motion) == PLACES[0]  # all alike


def test_zero_looks_is_error():
    with pytest.raises(UserError, match="pick.looks=0: use at least 1"):
        MostEdges(0)
