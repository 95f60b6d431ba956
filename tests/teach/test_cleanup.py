"""The clean-up against demonstrations whose truth is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from teach.cells import RADIUS, TOOL, dome, shown

from burnish.errors import PlanError, RecordingError
from burnish.teach.cleanup import FORCE, SHORTEST, cleaned, clear_of, closed, contact_points, on_surface
from burnish.teach.demonstration import Demonstration


def middle_of(demonstration: Demonstration) -> slice:
    rows = np.flatnonzero(demonstration.contact)
    return slice(int(rows[0]), int(rows[-1]) + 1)


def test_idle_ends_are_trimmed_and_phases_follow_each_other() -> None:
    taught = cleaned(shown(), dome()[1], TOOL)
    assert [piece.contact for piece in taught.pieces] == [False, True, False]
    # A second of idling at each end, but for what the smoothing takes of it.
    assert taught.pieces[0].samples.start >= 80
    assert taught.pieces[-1].samples.stop <= len(shown().t) - 80


def test_the_force_of_a_place_is_the_shown_one_however_noisy_it_was_felt() -> None:
    taught = cleaned(shown(noise=0.5), dome()[1], TOOL)
    (piece,) = taught.contacts
    x = contact_points(piece, TOOL.tip_radius)[:, 0]
    wanted = 8.0 + 3.0 * np.sin(np.pi * x / 0.02)
    # Within 2 √π · 2 mm at 0.2 mm a cycle: 0.5 N/√35 = 0.08 N; the weight takes 5 % = 0.15 N off the sine of 40 mm.
    assert np.abs(piece.force - wanted)[6:-6].max() < 0.4


def test_the_path_in_contact_lies_on_the_mould() -> None:
    taught = cleaned(shown(noise=0.5), dome()[1], TOOL)
    (piece,) = taught.contacts
    points = contact_points(piece, TOOL.tip_radius)
    # The true sphere, to what a grid of 2 mm and facets of 1 mm resolve.
    mould = dome()[0]
    off = np.linalg.norm(points - [0.0, 0.0, mould.vertices[:, 2].max() - RADIUS], axis=1) - RADIUS
    assert np.abs(off).max() < 5e-5


def test_the_path_is_as_long_as_it_was_shown_and_evenly_spaced() -> None:
    (piece,) = cleaned(shown(), dome()[1], TOOL).contacts
    points = contact_points(piece, TOOL.tip_radius)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = 2.0 * RADIUS * np.arcsin(0.02 / RADIUS)
    assert steps.sum() == pytest.approx(arc, abs=1e-3)
    assert steps.max() < 1.2 * steps.mean()


def test_a_job_shown_half_as_fast_has_the_same_force_at_the_same_place() -> None:
    (once,) = cleaned(shown(), dome()[1], TOOL).contacts
    (slow,) = cleaned(shown(times=2.0), dome()[1], TOOL).contacts
    x, y = (contact_points(piece, TOOL.tip_radius)[:, 0] for piece in (once, slow))
    assert np.abs(np.interp(x, y, slow.force) - once.force)[6:-6].max() < 0.2
    middle = len(once.speed) // 2
    assert once.speed[middle] == pytest.approx(2.0 * slow.speed[len(slow.speed) // 2], rel=0.05)


def test_a_mould_that_stood_elsewhere_is_found_from_where_the_tool_touched() -> None:
    shift = np.array([0.0, 0.0, 1.5e-3])
    taught = cleaned(shown(shift=shift), dome()[1], TOOL)
    nominal = taught.demonstration.placement
    assert taught.placement.p[2] - nominal.p[2] == pytest.approx(1.5e-3, abs=1e-4)


def test_a_contact_that_is_lost_for_a_moment_is_one_contact() -> None:
    assert len(cleaned(shown(lost=True), dome()[1], TOOL).contacts) == 1


def test_moments_of_contact_and_of_loss_are_closed_but_not_the_ends() -> None:
    t = 0.01 * np.arange(200)
    contact = np.zeros(200, dtype=bool)
    contact[50:150] = True
    contact[90:100] = False
    contact[5:10] = True
    expected = np.zeros(200, dtype=bool)
    expected[50:150] = True
    assert (closed(contact, t) == expected).all()


def test_a_demonstration_that_never_touches_is_refused() -> None:
    free = shown()
    free = replace(free, contact=np.zeros(len(free.t), dtype=bool))
    with pytest.raises(RecordingError, match="never touches"):
        cleaned(free, dome()[1], TOOL)


def test_contacts_that_lie_on_another_shape_are_refused() -> None:
    demonstration = shown()
    p = demonstration.p.copy()
    # A flat line where the dome is round: 1.3 mm off at the ends.
    p[middle_of(demonstration), 2] = p[middle_of(demonstration), 2].mean()
    with pytest.raises(PlanError, match="do not fit the mould"):
        cleaned(replace(demonstration, p=p), dome()[1], TOOL)


def test_forces_are_kept_within_what_is_replayed() -> None:
    demonstration = shown()
    (piece,) = cleaned(replace(demonstration, F=1.9 * demonstration.F), dome()[1], TOOL).contacts
    assert piece.force.max() == FORCE[1]


def test_a_free_piece_loses_only_its_ends_that_are_too_near() -> None:
    piece = cleaned(shown(), dome()[1], TOOL).pieces[0]
    gap = np.linspace(0.03, 0.0, len(piece.p))
    cut = clear_of(piece, gap, 0.01)
    assert cut is not None
    assert len(cut.p) == np.count_nonzero(gap > 0.01)
    assert (cut.p[0] == piece.p[0]).all()
    assert clear_of(piece, np.zeros(len(piece.p)), 0.01) is None
    assert (len(piece.p) - 1) * piece.ds >= SHORTEST


def test_a_tip_moved_onto_the_surface_touches_it() -> None:
    grid = dome()[1]
    centre = np.array([[0.01, 0.005, 0.06], [-0.02, 0.01, 0.05]])
    on, normal = on_surface(grid, centre, TOOL.tip_radius)
    assert grid.distance(on) == pytest.approx(TOOL.tip_radius, abs=1e-6)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)


def test_every_value_of_a_demonstration_has_to_be_a_number() -> None:
    demonstration = shown()
    F = demonstration.F.copy()
    F[7, 2] = np.nan
    with pytest.raises(RecordingError, match="F is not finite"):
        replace(demonstration, F=F)
