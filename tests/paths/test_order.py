"""The order of strokes: nothing lost, never worse, and the best one where all orders can be tried."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest

from burnish.paths.order import air_way, ordered, reversed_stroke
from burnish.paths.stroke import Stroke


def line(start: tuple[float, float], end: tuple[float, float]) -> Stroke:
    points = np.linspace([*start, 0.0], [*end, 0.0], 5)
    return Stroke(
        points=points, normals=np.tile([0.0, 0.0, 1.0], (5, 1)), feed=np.arange(1.0, 6.0), force=np.arange(5.0)
    )


def scattered(seed: int, count: int) -> list[Stroke]:
    rng = np.random.default_rng(seed)
    return [line(tuple(a), tuple(b)) for a, b in rng.uniform(0.0, 0.1, (count, 2, 2))]


def fingerprint(stroke: Stroke) -> frozenset[bytes]:
    return frozenset(row.tobytes() for row in np.column_stack((stroke.points, stroke.feed, stroke.force)))


@pytest.mark.parametrize("seed", range(8))
def test_every_stroke_is_run_once(seed: int) -> None:
    strokes = scattered(seed, 25)
    assert {fingerprint(one) for one in ordered(strokes)} == {fingerprint(one) for one in strokes}
    assert len(ordered(strokes)) == 25


@pytest.mark.parametrize("seed", range(20))
def test_air_way_is_never_longer_than_in_the_order_given(seed: int) -> None:
    for count in (2, 3, 12):
        strokes = scattered(seed, count)
        assert air_way(ordered(strokes)) <= air_way(strokes) + 1e-12
        again = ordered(ordered(strokes))
        assert air_way(again) <= air_way(ordered(strokes)) + 1e-12


def test_good_order_is_left_alone() -> None:
    strokes = [
        line((0.0, y), (0.05, y)) if k % 2 == 0 else line((0.05, y), (0.0, y)) for k, y in enumerate([0.0, 0.01, 0.02])
    ]
    assert air_way(ordered(strokes)) == pytest.approx(0.02)


def test_lines_that_all_run_one_way_are_run_back_and_forth() -> None:
    strokes = [line((0.0, 0.01 * k), (0.1, 0.01 * k)) for k in range(6)]
    assert air_way(ordered(strokes)) == pytest.approx(0.05)


@pytest.mark.parametrize("seed", range(6))
def test_four_strokes_are_near_the_best_of_all_orders(seed: int) -> None:
    strokes = scattered(seed, 4)
    best = min(
        air_way([reversed_stroke(strokes[k]) if back else strokes[k] for k, back in zip(order, turned, strict=True)])
        for order in permutations(range(4))
        for turned in product((False, True), repeat=4)
    )
    assert air_way(ordered(strokes)) <= 1.25 * best


def test_reversed_stroke_carries_feed_and_force_along() -> None:
    stroke = reversed_stroke(line((0.0, 0.0), (0.1, 0.0)))
    assert stroke.points[0, 0] == 0.1
    assert (stroke.feed[0], stroke.force[0]) == (5.0, 4.0)


@pytest.mark.parametrize("count", [0, 1])
def test_nothing_to_order_stays(count: int) -> None:
    assert len(ordered(scattered(0, count))) == count
