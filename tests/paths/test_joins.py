"""Curves joined into one path: each once, tangent, and only where there is room."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.core import Array
from burnish.paths.joins import closed, joined
from burnish.paths.track import dense

GAP = 2e-3


def anywhere(xy: Array) -> bool:
    return True


def line(y: float, start: float = 0.0, end: float = 0.05, force: float = 10.0) -> Array:
    xy = dense(np.array([[start, y], [end, y]]))
    return np.column_stack((xy, np.full(len(xy), force)))


def ring(radius: float) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, 721)
    xy = dense(radius * np.column_stack((np.cos(angle), np.sin(angle))))
    xy[-1] = xy[0]
    return np.column_stack((xy, np.full(len(xy), 10.0)))


def turning(path: Array) -> Array:
    """Change of heading from place to place [rad]."""
    heading = np.unwrap(np.arctan2(*np.diff(path[:, :2], axis=0).T[::-1]))
    return np.abs(np.diff(heading))


def test_lines_are_run_back_and_forth_round_half_circles() -> None:
    (path,) = joined([[line(0.0)], [line(GAP)], [line(2 * GAP)]], GAP, anywhere)
    assert turning(path).max() < 0.6  # the radius is 1 mm, the pitch up to 0.4 mm
    assert path[:, 0].max() == pytest.approx(0.05, abs=0.15e-3)
    assert path[-1, 0] == pytest.approx(0.05, abs=0.3e-3)
    assert path[:, 0].min() > -0.3e-3


def test_longer_line_is_cut_where_the_turn_begins() -> None:
    (path,) = joined([[line(0.0)], [line(GAP, end=0.053)]], GAP, anywhere)
    assert path[:, 0].max() < 0.0503


@pytest.mark.parametrize("room", [True, False])
def test_lines_stay_apart_where_they_end_far_apart_or_the_turn_has_no_room(room: bool) -> None:
    other = line(GAP, 0.06, 0.11) if room else line(GAP)
    assert len(joined([[line(0.0)], [other]], GAP, lambda xy: room)) == 2


def test_rings_go_over_into_each_other_without_a_corner() -> None:
    (path,) = joined([[ring(0.02)], [ring(0.018)], [ring(0.016)]], GAP, anywhere)
    assert turning(path).max() < 0.15
    angle = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))
    assert abs(angle[-1] - angle[0]) > 0.9 * 6 * np.pi
    assert (np.sign(np.diff(angle)) == np.sign(angle[-1] - angle[0])).all()


def test_force_goes_over_from_curve_to_curve() -> None:
    (path,) = joined([[line(0.0, force=10.0)], [line(GAP, force=6.0)]], GAP, anywhere)
    assert (path[0, 2], path[-1, 2]) == (10.0, 6.0)
    assert np.abs(np.diff(path[:, 2])).max() < 1.0


def test_no_curve_is_lost_where_a_hole_parts_them() -> None:
    levels = [[line(0.0, 0.0, 0.1)], [line(GAP, 0.0, 0.04), line(GAP, 0.06, 0.1)], [line(2 * GAP, 0.0, 0.1)]]
    paths = joined(levels, GAP, anywhere)
    straight = sum(
        np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1)[np.abs(np.diff(path[:, 1])) < 1e-9].sum() for path in paths
    )
    assert straight == pytest.approx(0.28, abs=6 * GAP)


def test_ring_is_closed_and_line_is_not() -> None:
    assert closed(ring(0.01))
    assert not closed(line(0.0))
