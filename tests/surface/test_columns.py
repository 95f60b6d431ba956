"""Inside or outside, told by the surfaces above a place."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from surface.shapes import box, box_distance, sheet

from burnish.errors import MouldError
from burnish.surface.columns import inside
from burnish.surface.winding import merged

ORIGIN, SPACING, SHAPE = np.array([-0.06, -0.06, -0.02]), 4e-3, (31, 31, 21)
NODES = ORIGIN + SPACING * np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing="ij"), axis=-1)


def found(corners: np.ndarray) -> np.ndarray:
    return inside(*merged(corners), ORIGIN, SPACING, SHAPE)


def test_box_with_walls_on_the_columns_is_filled_exactly() -> None:
    distance = box_distance(NODES.reshape(-1, 3), 0.08, 0.064, 0.03).reshape(SHAPE)
    clear = np.abs(distance) > SPACING / 100  # a node on the surface may go either way
    np.testing.assert_array_equal(found(box(0.08, 0.064, 0.03))[clear], distance[clear] < 0)


def test_ball_is_filled_exactly() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.04)
    distance = np.linalg.norm(NODES, axis=-1) - 0.04
    clear = np.abs(distance) > 2e-4  # the facets lie up to 0.12 mm inside the sphere
    np.testing.assert_array_equal(found(ball.triangles)[clear], distance[clear] < 0)


def test_solids_that_overlap_count_as_one() -> None:
    both = np.concatenate((box(0.08, 0.03, 0.03), box(0.03, 0.08, 0.05)))
    distance = np.minimum(
        box_distance(NODES.reshape(-1, 3), 0.08, 0.03, 0.03), box_distance(NODES.reshape(-1, 3), 0.03, 0.08, 0.05)
    ).reshape(SHAPE)
    clear = np.abs(distance) > SPACING / 100
    np.testing.assert_array_equal(found(both)[clear], distance[clear] < 0)


def test_cavity_is_empty_and_what_lies_above_it_is_full() -> None:
    hollow = np.concatenate((box(0.1, 0.1, 0.06), (box(0.06, 0.06, 0.02) + [0, 0, 0.02])[:, ::-1]))
    column = found(hollow)[15, 15]
    z = NODES[15, 15, :, 2]
    assert column[(z > 0.001) & (z < 0.019)].all()
    assert not column[(z > 0.021) & (z < 0.039)].any()
    assert column[(z > 0.041) & (z < 0.059)].all()


def test_everything_under_an_open_surface_is_inside() -> None:
    x = np.linspace(-0.04, 0.04, 5)
    result = found(sheet(x, x, np.full((5, 5), 0.03)))
    assert result[15, 15, NODES[15, 15, :, 2] < 0.0299].all()
    assert not result[15, 15, NODES[15, 15, :, 2] > 0.0301].any()
    assert not result[0].any()


@pytest.mark.parametrize("batch", [1, 1 << 20])
def test_result_does_not_depend_on_how_the_work_is_cut(monkeypatch: pytest.MonkeyPatch, batch: int) -> None:
    expected = found(box(0.08, 0.064, 0.03))
    monkeypatch.setattr("burnish.surface.columns._PAIRS", batch)
    np.testing.assert_array_equal(found(box(0.08, 0.064, 0.03)), expected)


def test_heap_of_triangles_from_end_to_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("burnish.surface.columns.MOST_PAIRS", 5000)
    heap = np.concatenate([box(0.08, 0.064, 0.001 * height) for height in range(1, 20)])
    with pytest.raises(MouldError, match="deep seen from above"):
        found(heap)
