"""What is left of a job after a stop, and how it leads in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from burnish.errors import InputError
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.passes import LEAD_IN, LIGHT, after, eased, legs_of, piece, split, without


def line(length: float = 0.1) -> Stroke:
    """A straight line along x with a force that grows along it."""
    x = np.arange(0.0, length + 1e-9, 0.5e-3)
    n = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    points = np.column_stack([x, 0.0 * x, 0.0 * x])
    return Stroke(points=points, normals=n, feed=np.full(len(x), 0.02), force=10.0 + 20.0 * x)


def test_rest_of_a_stopped_stroke_begins_one_lead_in_before_the_stop_and_later_strokes_are_whole() -> None:
    legs = legs_of([[line(), line(0.05)], [line()]])
    left = after(legs, 1, 1, 0.0603)
    assert [(leg.number, leg.stroke) for leg in left] == [(1, 1), (1, 2), (2, 1)]
    assert left[0].begun == pytest.approx(0.0603 - LEAD_IN)
    assert left[0].lead == pytest.approx(LEAD_IN)
    assert left[0].path.points[0, 0] == pytest.approx(0.0603 - LEAD_IN)
    assert left[0].path.points[-1, 0] == pytest.approx(0.1)
    assert left[1] is legs[1]


def test_stop_close_to_the_start_leads_in_from_the_start() -> None:
    left = after(legs_of([[line()]]), 1, 1, 0.004)
    assert left[0].begun == 0.0
    assert left[0].lead == pytest.approx(0.004)


def test_finished_stroke_is_not_done_again() -> None:
    legs = legs_of([[line(), line()]])
    assert after(legs, 1, 1, 0.0995) == [legs[1]]
    assert after(legs, 1, 2, 0.1) == []


def test_stop_of_a_rest_is_counted_from_the_start_of_the_whole_stroke() -> None:
    once = after(legs_of([[line()]]), 1, 1, 0.03)
    again = after(once, 1, 1, 0.07)
    assert again[0].begun == pytest.approx(0.07 - LEAD_IN)
    assert again[0].path.points[-1, 0] == pytest.approx(0.1)


def test_lead_in_is_light_and_the_force_is_whole_behind_the_seam() -> None:
    stroke = eased(line(), 0.05)
    assert np.all(stroke.force[stroke.arc < 0.045] == LIGHT)
    behind = stroke.arc > 0.055
    assert np.allclose(stroke.force[behind], 10.0 + 20.0 * stroke.arc[behind])
    # Half of it is there at the seam, so that what a stop faded out is faded in.
    assert np.interp(0.05, stroke.arc, stroke.force) == pytest.approx(0.5 * (LIGHT + 11.0), abs=0.1)


def test_two_pieces_are_the_whole_stroke() -> None:
    front, rest = split(legs_of([[line()]])[0], 0.0371)
    assert rest is not None
    assert front.path.length + rest.path.length == pytest.approx(0.1)
    assert np.allclose(front.path.points[-1], rest.path.points[0])
    assert rest.begun == pytest.approx(0.0371)


def test_short_piece_can_be_timed() -> None:
    short = piece(line(), 0.0201, 0.0203)
    assert len(short.points) >= 4
    assert short.length == pytest.approx(0.2e-3)


def test_skipped_strokes_are_left_out_of_every_pass_and_unknown_ones_refused() -> None:
    legs = legs_of([[line(), line(), line()]] * 2)
    assert [(leg.number, leg.stroke) for leg in without(legs, {1, 3})] == [(1, 2), (2, 2)]
    with pytest.raises(InputError, match="no stroke 4 to skip; expected numbers from 1 to 3"):
        without(legs, {2, 4})
    with pytest.raises(InputError, match="all 3 strokes"):
        without(legs, {1, 2, 3})


def test_rest_of_a_stopped_stroke_leans_and_yields_as_the_whole_one() -> None:
    whole = line()
    soft = replace(whole, tilt=Tilt(angle=0.2, heading=1.0), stiffness=1.0 - 5.0 * whole.points[:, 0])
    (rest,) = after(legs_of([[soft]]), 1, 1, 0.06)
    assert rest.path.tilt == soft.tilt
    assert rest.path.stiffness is not None
    np.testing.assert_allclose(rest.path.stiffness, 1.0 - 5.0 * rest.path.points[:, 0], atol=1e-12)
