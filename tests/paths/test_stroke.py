"""Strokes and the form in which a plan is kept."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from burnish.errors import PlanError
from burnish.paths.stroke import Stroke, as_plan, from_plan
from burnish.paths.tilt import Tilt


def stroke(**changes: Any) -> Stroke:
    line = np.linspace(0.0, 0.1, 11)
    values: dict[str, Any] = {
        "points": np.column_stack((line, 0 * line, 0 * line)),
        "normals": np.tile([0.0, 0.0, 1.0], (11, 1)),
        "feed": np.full(11, 0.02),
        "force": np.full(11, 10.0),
    }
    return Stroke(**{**values, **changes})


def test_plan_comes_back_from_json_bit_for_bit() -> None:
    strokes = [stroke(), stroke(feed=np.linspace(0.01, 0.03, 11) / 3)]
    plan = json.loads(json.dumps(as_plan(strokes)))
    assert list(plan) == ["strokes"]
    assert all(list(one) == ["points", "normals", "feed", "force"] for one in plan["strokes"])
    for one, back in zip(strokes, from_plan(plan), strict=True):
        for name in ("points", "normals", "feed", "force"):
            np.testing.assert_array_equal(getattr(one, name), getattr(back, name))


def test_lean_and_stiffness_come_back_from_json_and_stand_there_only_where_they_are_not_as_usual() -> None:
    leaning = stroke(tilt=Tilt(angle=0.2, heading=-1.0 / 3.0), stiffness=np.linspace(0.25, 1.0, 11))
    plan = json.loads(json.dumps(as_plan([leaning, stroke()])))
    assert set(plan["strokes"][0]) - set(plan["strokes"][1]) == {"tilt", "stiffness"}
    back, usual = from_plan(plan)
    assert back.tilt == leaning.tilt
    np.testing.assert_array_equal(back.stiffness, leaning.stiffness)
    assert usual.tilt == Tilt()
    assert usual.stiffness is None


def test_some_points_keep_their_lean_and_their_stiffness() -> None:
    leaning = stroke(tilt=Tilt(angle=0.2), stiffness=np.linspace(0.25, 1.0, 11))
    back = leaning.rows(slice(None, None, -1))
    assert back.tilt == leaning.tilt
    assert back.stiffness is not None
    np.testing.assert_allclose(back.stiffness, np.linspace(1.0, 0.25, 11))
    np.testing.assert_array_equal(back.points, leaning.points[::-1])
    few = leaning.rows(np.arange(11) < 3)
    assert (len(few.points), len(few.feed)) == (3, 3)


def test_length_is_that_of_the_line() -> None:
    assert stroke().length == pytest.approx(0.1)
    np.testing.assert_allclose(stroke().arc, np.linspace(0, 0.1, 11))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"points": np.zeros((11, 2))}, "points has shape"),
        ({"points": np.zeros((1, 3))}, "at least two points"),
        ({"points": 3.0}, "at least two points"),
        ({"points": [[0, 0, 0], [1, 2]]}, "no array of numbers"),
        ({"points": None}, "expected"),
        ({"normals": np.zeros((11, 3))}, "not of length 1"),
        ({"feed": np.zeros(11)}, "feed is not positive"),
        ({"feed": np.full(11, np.nan)}, "not a finite number"),
        ({"force": np.full(11, -1.0)}, "force is negative"),
        ({"force": np.ones(10)}, "force has shape"),
        ({"stiffness": np.ones(10)}, "stiffness has shape"),
        ({"stiffness": np.full(11, 0.2)}, "expected a share of 0.25 to 1"),
        ({"stiffness": np.full(11, 1.1)}, "expected a share of 0.25 to 1"),
        ({"stiffness": "soft"}, "no array of numbers"),
    ],
)
def test_stroke_that_no_arm_can_follow_is_refused(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(PlanError, match=reason):
        stroke(**changes)


@pytest.mark.parametrize(
    "plan",
    [
        {},
        {"strokes": []},
        {"strokes": {}},
        {"strokes": [3]},
        {"strokes": [{"points": []}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "colour": "red"}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "feed": "fast"}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "tilt": 0.2}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "tilt": {"angle": 0.2}}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "tilt": {"angle": 10**400, "heading": 0.0}}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "tilt": {"angle": "0.2", "heading": 0.0}}]},
        {"strokes": [{**as_plan([stroke()])["strokes"][0], "tilt": {"angle": 0.02, "heading": 0.0}}]},
        [],
        None,
    ],
)
def test_plan_of_another_form_is_refused(plan: Any) -> None:
    with pytest.raises(PlanError, match="expected"):
        from_plan(plan)
