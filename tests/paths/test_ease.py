"""A feed that a wrist can follow, and a force with which it removes the same."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.paths.ease import duration, eased, followable
from burnish.paths.stroke import Stroke

RADIUS = 0.01
TURN_RATE = 0.3


def over_an_edge(feed: float) -> Stroke:
    """A flat, a quarter of a round edge of 10 mm, and a flat again."""
    angle = np.linspace(0.0, 0.5 * np.pi, 158)
    flat = np.linspace(0.02, 1e-4, 200)
    ends = (
        np.column_stack((-flat, 0.0 * flat, 0.0 * flat + RADIUS)),
        np.column_stack((0.0 * flat + RADIUS, 0.0 * flat, -flat[::-1])),
    )
    normals = np.column_stack((np.sin(angle), 0.0 * angle, np.cos(angle)))
    points = np.concatenate((ends[0], RADIUS * normals, ends[1]))
    up = np.concatenate((np.tile(normals[0], (200, 1)), normals, np.tile(normals[-1], (200, 1))))
    return Stroke(points=points, normals=up, feed=np.full(len(points), feed), force=np.full(len(points), 10.0))


def test_followable_feed_turns_the_tool_at_the_allowed_rate() -> None:
    slower = followable(over_an_edge(0.02))
    assert np.allclose(slower.feed[203:355], TURN_RATE * RADIUS, rtol=1e-3)
    assert np.all(slower.feed[:198] == 0.02)
    assert np.all(slower.feed[-198:] == 0.02)


def test_a_slow_feed_stays_what_it_is() -> None:
    stroke = over_an_edge(2e-3)
    assert np.array_equal(followable(stroke).feed, stroke.feed)
    assert np.allclose(eased(stroke, 1.0).force, stroke.force, rtol=1e-12)


def test_a_tool_that_does_not_spin_presses_as_before() -> None:
    assert np.array_equal(eased(over_an_edge(0.02), 0.0).force, np.full(558, 10.0))


@pytest.mark.parametrize("rim", [0.0, 5e-3, 0.05, 5.0])
def test_an_eased_stroke_removes_the_same_everywhere(rim: float) -> None:
    stroke = over_an_edge(0.02)
    slower = eased(stroke, rim)
    # What is rubbed in a second, for as many seconds as a metre takes.
    removed = [one.force * np.hypot(one.feed, rim) / one.feed for one in (stroke, slower)]
    assert np.allclose(*removed, rtol=1e-12)
    assert slower.feed.min() < 0.2 * stroke.feed.min()


def test_duration_is_that_of_the_feed() -> None:
    stroke = over_an_edge(0.02)
    assert duration(stroke) == pytest.approx(stroke.length / 0.02)
    slower = followable(stroke)
    ends = 2.0 * 0.02 / 0.02
    assert duration(slower) == pytest.approx(ends + 0.5 * np.pi / TURN_RATE, rel=0.02)
