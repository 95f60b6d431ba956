"""Areas cut into patches, and their rows joined into chains."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.paths.patches import decompose, intervals
from burnish.paths.snake import Row, chains, plan_view


def area(*rows: str) -> np.ndarray:
    """Good places drawn as #, the lowest row last."""
    return np.array([[place == "#" for place in row] for row in reversed(rows)])


def test_intervals_are_runs_of_at_least_the_least() -> None:
    row = area("##..###.#")[0]
    assert intervals(row, 1) == [(0, 1), (4, 6), (8, 8)]
    assert intervals(row, 3) == [(4, 6)]


def test_round_area_is_one_patch() -> None:
    patches = decompose(area("..###..", ".#####.", "#######", ".#####.", "..###.."), 2, 3)
    assert len(patches) == 1
    assert patches[0].spans == [(2, 4), (1, 5), (0, 6), (1, 5), (2, 4)]
    assert (patches[0].below, patches[0].above) == (None, None)


def test_hole_makes_four_patches_and_the_wide_ones_own_the_meeting_lines() -> None:
    below, left, right, above = decompose(area("#########", "###...###", "###...###", "#########"), 2, 9)
    assert below.spans == above.spans == [(0, 8)]
    assert left.spans == [(0, 2)] * 2
    assert right.spans == [(6, 8)] * 2
    assert (left.below, left.above) == (right.below, right.above) == (0, 3)
    assert (below.below, below.above, above.below, above.above) == (None, None, None, None)


def test_row_that_suddenly_widens_begins_a_patch_that_owns_the_line() -> None:
    narrow, wide = decompose(area("########", "###....."), 2, 3)
    assert (narrow.below, narrow.above) == (None, 1)
    assert (wide.below, wide.above) == (None, None)


def test_row_that_suddenly_narrows_leaves_the_line_to_the_wide_one() -> None:
    wide, narrow = decompose(area("###.....", "########"), 2, 3)
    assert (wide.below, wide.above) == (None, None)
    assert (narrow.below, narrow.above) == (0, None)


def test_islands_are_patches_of_their_own() -> None:
    patches = decompose(area("###...", "......", "...###"), 2, 9)
    assert [patch.first_row for patch in patches] == [0, 2]
    assert all(patch.below is None and patch.above is None for patch in patches)


LINES = np.array([0.0, 0.002, 0.004])


def row(y: float, start: float, end: float) -> Row:
    return Row(y=y, start=start, end=end)


def test_rows_are_run_back_and_forth() -> None:
    (chain,) = chains(LINES, [[row(y, 0.0, 0.05)] for y in LINES], lambda xy: True)
    assert [(piece.start, piece.end) for piece in chain] == [(0.0, 0.05), (0.05, 0.0), (0.0, 0.05)]


def test_turn_is_a_half_circle_from_line_to_line_without_a_corner() -> None:
    (chain,) = chains(LINES, [[row(y, 0.0, 0.05)] for y in LINES], lambda xy: True)
    path = plan_view(chain)
    heading = np.unwrap(np.arctan2(*np.diff(path, axis=0).T[::-1]))
    pitch = np.linalg.norm(np.diff(path, axis=0), axis=1)
    # On a circle of 1 mm a heading turns by the length over the radius, half of it at the ends of a piece.
    assert np.abs(np.diff(heading)).max() < 1.1 * pitch.max() / 1e-3
    assert path[:, 0].max() == pytest.approx(0.051, abs=10e-6)
    assert path[:, 0].min() == pytest.approx(-0.001, abs=10e-6)


def test_longer_row_is_cut_where_the_turn_begins() -> None:
    rows = [[row(0.0, 0.0, 0.05)], [row(0.002, 0.0, 0.053)], []]
    (chain,) = chains(LINES, rows, lambda xy: True)
    assert (chain[0].end, chain[1].start) == (0.05, 0.05)


@pytest.mark.parametrize(
    ("far", "room"), [pytest.param(0.06, True, id="ends far apart"), pytest.param(0.05, False, id="no room to turn")]
)
def test_rows_that_cannot_be_joined_are_chains_of_their_own(far: float, room: bool) -> None:
    rows = [[row(0.0, 0.0, 0.05)], [row(0.002, 0.0, far)], []]
    assert len(list(chains(LINES, rows, lambda xy: room))) == 2


def test_every_row_is_run_exactly_once_round_a_hole() -> None:
    rows = [[row(0.0, 0.0, 0.1)], [row(0.002, 0.0, 0.04), row(0.002, 0.06, 0.1)], [row(0.004, 0.0, 0.1)]]
    found = [piece for chain in chains(LINES, rows, lambda xy: True) for piece in chain]
    assert sorted(piece.y for piece in found) == [0.0, 0.002, 0.002, 0.004]
    assert sum(abs(piece.end - piece.start) for piece in found) == pytest.approx(0.28)
