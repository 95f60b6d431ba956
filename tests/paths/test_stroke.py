"""Strokes and the form in which a plan is kept."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from burnish.errors import PlanError
from burnish.paths.stroke import Stroke, as_plan, from_plan


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
        [],
        None,
    ],
)
def test_plan_of_another_form_is_refused(plan: Any) -> None:
    with pytest.raises(PlanError, match="expected"):
        from_plan(plan)
