"""The plan check: each kind of plan that cannot be done is refused with its reason, and one that can be done is not."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from burnish.check.demand import demand
from burnish.check.plan import check
from burnish.check.route import route, sparse
from burnish.check.scaling import derated
from burnish.check.ways import Workplace, followed
from burnish.core import Array, State
from burnish.errors import PlanError
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.cell import HOME, READY, TURN, Placement, tool_down
from burnish.polish.feasible import track
from burnish.polish.process import timed
from burnish.polish.recipe import Bounds, Recipe
from burnish.rotation import exp
from burnish.runtime.limits import Limits
from burnish.surface import DistanceGrid, Mould

TOP = 0.02
"""Height of the block [m]."""


def box(x: float, y: float, width: float, depth: float, height: float) -> Array:
    corner = np.array([(i, j, k) for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (0.0, 1.0)])
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
             (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip
    return (np.array([x, y, 0.0]) + corner * [width, depth, height])[np.array(faces)]


@lru_cache
def block(*more: tuple[float, float, float, float, float]) -> tuple[Mould, DistanceGrid]:
    boxes = [box(*one) for one in ((0.0, 0.0, 0.12, 0.06, TOP), *more)]
    mould = Mould.of("block", np.concatenate(boxes))
    return mould, DistanceGrid.of(mould, 1.5e-3)


def line(y: float = 0.0, low: float = -0.02, high: float = 0.02, feed: float = 0.02, force: float = 10.0) -> Stroke:
    x = np.linspace(low, high, 81)
    level = np.ones_like(x)
    return Stroke(
        points=np.column_stack((x, y * level, TOP * level)),
        normals=np.tile([0.0, 0.0, 1.0], (81, 1)),
        feed=feed * level,
        force=force * level,
    )


def place(
    x: float = 0.0,
    y: float = -0.34,
    z: float = 0.2,
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mould: tuple[Mould, DistanceGrid] | None = None,
    tool: PolishingTool | None = None,
) -> Workplace:
    model = (tool or PolishingTool()).on(Model.jaco2())
    return Workplace(
        model=model,
        limits=Limits.jaco2(),
        mould=(mould or block())[0],
        grid=(mould or block())[1],
        placement=Placement(p=np.array([x, y, z]), R=exp(np.array(turn)) @ TURN),
        upright=tool_down(model),
        uncertainty=4e-3,
    )


def refusal(strokes: list[Stroke], where: Workplace, recipe: Recipe | None = None, **more: Any) -> str:
    with pytest.raises(PlanError) as refused:
        check(where, strokes, recipe or Recipe(), **more)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_plan_that_can_be_done_comes_back_as_it_was() -> None:
    strokes = [line(-0.01), line(0.01)]
    plan = check(place(), strokes, Recipe(), made_for=block()[0].sha256)
    assert [one.points.tolist() for one in plan.strokes] == [one.points.tolist() for one in strokes]
    assert all((one.feed == 0.02).all() for one in plan.strokes)
    assert plan.notes == ()
    assert plan.length == pytest.approx(0.08)
    assert plan.clearances.itself is not None


@pytest.mark.parametrize(
    ("where", "reason"),
    [
        ({"y": -0.75}, "cannot bring its tool|out of the arm's reach"),
        ({"z": 0.5}, "cannot bring its tool|out of the arm's reach"),
        ({"y": -0.10, "z": 0.1}, "joint 3 comes within .*° of its limit"),
        ({"y": -0.60}, "the arm is singular"),
        ({"y": -0.10, "z": 0.27}, "stand under the mould"),
        ({"y": -0.40, "z": 0.0, "turn": (0.0, 1.2, 0.0)}, "the hand runs into the floor"),
    ],
)
def test_mould_in_a_bad_place_is_refused_with_the_reason(where: dict[str, Any], reason: str) -> None:
    said = refusal([line(-0.01), line(0.01)], place(**where))
    assert re.search(reason, said)
    assert "mm of the mould" in said
    assert "Move or turn the mould" in said


def test_hand_too_near_the_upper_arm_is_refused() -> None:
    mould = Mould.of("small", box(0.0, 0.0, 0.06, 0.06, TOP))
    small = mould, DistanceGrid.of(mould, 1.5e-3)
    said = refusal([line(-0.01), line(0.01)], place(y=-0.13, mould=small))
    assert "stroke 1 at" in said
    assert re.search("upper arm (comes within|runs into).* hand", said)


def test_hand_that_meets_a_tower_beside_the_path_is_refused() -> None:
    tower = block((0.05, 0.0, 0.02, 0.06, 0.2))
    assert "runs into the mould" in refusal([line(-0.01), line(0.01)], place(mould=tower))


def test_tool_that_leans_has_room_on_the_side_to_which_it_does_not_lean() -> None:
    tower = block((0.05, 0.0, 0.01, 0.06, 0.08))
    upright = [line(-0.01, -0.03, 0.0), line(0.01, -0.03, 0.0)]
    towards, away = (
        [replace(one, tilt=Tilt(angle=0.4, heading=heading)) for one in upright] for heading in (0.0, np.pi)
    )
    assert "the hand runs into the mould" in refusal(towards, place(mould=tower))
    room, more = (check(place(mould=tower), strokes, Recipe()).clearances.around for strokes in (upright, away))
    assert more.distance > room.distance + 3e-3


def test_plan_of_a_leaning_tool_comes_back_as_it_was() -> None:
    strokes = [replace(line(y), tilt=Tilt(angle=float(np.deg2rad(10.0)), heading=1.0)) for y in (-0.01, 0.01)]
    plan = check(place(), strokes, Recipe())
    assert [one.tilt for one in plan.strokes] == [one.tilt for one in strokes]
    assert all((one.feed == 0.02).all() for one in plan.strokes)
    assert plan.notes == ()


def test_post_between_two_strokes_is_met_in_the_air() -> None:
    post = block((0.0, 0.0, 0.01, 0.04, 0.055))
    said = refusal([line(0.0, -0.05, -0.03), line(0.0, 0.03, 0.05)], place(mould=post))
    assert said.startswith("the way to")
    assert "the tip" in said


@pytest.mark.parametrize(
    ("changes", "reason"),
    [({"length": 0.05, "body_com": 0.01}, "the hand runs into"), ({"body_radius": 0.06}, "tool's body runs into")],
)
def test_tool_that_brings_the_hand_to_the_mould_is_refused(changes: dict[str, float], reason: str) -> None:
    tool = replace(PolishingTool(), **changes)
    assert reason in refusal([line(-0.01), line(0.01)], place(tool=tool), Recipe(tool=tool))


def test_force_that_takes_too_much_torque_is_refused() -> None:
    recipe = Recipe(limits=Bounds(joint_torque=0.3))
    said = refusal([line(force=20.0)], place(y=-0.5), recipe)
    assert "of its torque, pressing with 20 N" in said
    assert "Lower the force" in said


def test_heavy_tool_is_refused_by_its_weight() -> None:
    tool = replace(PolishingTool(), body_mass=2.0)
    said = refusal([line(force=2.0)], place(tool=tool), Recipe(tool=tool, limits=Bounds(joint_torque=0.4)))
    assert "of its torque" in said


def nodding(angle: float) -> Array:
    swing = angle * np.where(np.arange(81) % 4 < 2, 1.0, -1.0)
    return np.column_stack((np.sin(swing), np.zeros_like(swing), np.cos(swing)))


def changed(**changes: Callable[[Stroke], Array]) -> Stroke:
    one = line(0.01)
    return replace(one, **{name: change(one) for name, change in changes.items()})


@pytest.mark.parametrize(
    ("stroke", "reason"),
    [
        (changed(points=lambda one: one.points + [0.0, 0.0, 1e-3]), "1.00 mm above the surface"),
        (changed(points=lambda one: one.points - [0.0, 0.0, 1e-3]), "1.00 mm below the surface"),
        (changed(points=lambda one: one.points + [0.0, 0.04, 0.0]), "above the surface"),
        (changed(normals=lambda one: -one.normals), "points into the mould"),
        (changed(normals=lambda one: np.tile([np.sin(0.4), 0.0, np.cos(0.4)], (81, 1))), "23° off the surface's"),
        (changed(force=lambda one: 4.0 * one.force), "force 40 N is out of range"),
        (changed(force=lambda one: 0.0 * one.force), "force 0 N is out of range"),
        (changed(feed=lambda one: 10.0 * one.feed), "feed 0.2 m/s is out of range"),
        (changed(feed=lambda one: 1e-3 * one.feed), "feed 2e-05 m/s is out of range"),
        (changed(points=lambda one: one.points[[*range(40), *([39] * 41)]]), "points are the same"),
        (changed(points=lambda one: 1e-3 * one.points + [0.0, 0.01, TOP * 0.999]), "expected at least 3 over"),
        (line(0.0, -0.25, 0.25), "the path is torn"),
        (changed(normals=lambda one: nodding(0.2)), "turns the tool too fast"),
    ],
)
def test_stroke_that_is_no_work_on_this_mould_is_refused_by_its_number(stroke: Stroke, reason: str) -> None:
    said = refusal([line(-0.01), stroke], place())
    assert said.startswith("stroke 2 at (")
    assert reason in said


def test_plan_of_another_mould_is_refused() -> None:
    assert "made for a mould" in refusal([line()], place(), made_for="0" * 64)


def test_plan_without_strokes_is_refused() -> None:
    assert "no strokes" in refusal([], place())


def test_feed_is_lowered_to_the_joint_speed_and_no_further() -> None:
    recipe = Recipe(limits=Bounds(joint_speed=0.1))
    plan = check(place(), [line(feed=0.03)], recipe)
    assert 0.9 * 0.1 < plan.speed.value <= 0.1
    assert plan.strokes[0].feed.min() < 0.03
    assert "the feed was lowered" in plan.notes[0]


def test_feed_that_would_have_to_be_lowered_too_much_is_refused() -> None:
    said = refusal([line(feed=0.08)], place(), Recipe(limits=Bounds(joint_speed=0.1, least_feed=0.9)))
    assert "the feed of 80 mm/s is too fast for the arm" in said
    assert "Lower the feed to" in said


def test_derating_leaves_the_feed_alone_where_no_joint_is_too_fast() -> None:
    stroke = line()
    arc = np.linspace(0.0, stroke.length, 200)
    share = np.where(np.abs(arc - 0.02) < 2e-3, 1.8, 0.5)
    slower = derated(stroke, arc, np.full(200, 0.02), share, 0.9)
    near = np.abs(stroke.arc - 0.02)
    assert np.allclose(slower.feed[near < 2e-3], 0.02 * 0.95 * 0.5)
    assert np.allclose(slower.feed[near > 5e-3], 0.02)
    assert derated(stroke, arc, np.full(200, 0.02), 0.5 * share, 0.9) is stroke


@pytest.mark.parametrize("spindle", [0.0, 300.0])
def test_demand_is_what_the_whole_model_gives_at_every_looked_at_node(spindle: float) -> None:
    """Against M q̈ + h + g − Jᵀ F without interpolation, from central differences of the joint positions."""
    where, stroke = place(), replace(line(0.01), tilt=Tilt(angle=0.43 if spindle else 0.0, heading=1.0))
    tool = PolishingTool(spindle=spindle)
    path = timed(stroke, where.placement, where.upright, tool.tip_radius)
    nodes = sparse(path)
    model = where.model
    q0 = track(model, path.p[:1], path.R[:1], READY).q[0]
    found = demand(model, path, nodes, track(model, path.p[nodes], path.R[nodes], q0).q, limits=where.limits, tool=tool)
    for k in (len(found.nodes) // 2, len(found.nodes) // 3):
        node = int(found.nodes[k])
        window = slice(node - 10, node + 11)
        q = track(model, path.p[window], path.R[window], q0).q
        dq, ddq = (q[11] - q[9]) / (2 * path.dt), (q[20] - 2.0 * q[10] + q[0]) / (10 * path.dt) ** 2
        arm = model.at(State(t=0.0, q=q[10], dq=dq))
        v = path.v[node, :3] / np.linalg.norm(path.v[node, :3])
        if spindle:
            # The rim at ω r sin θ is far faster than the feed and than the spin about the normal: the drag is 0.98 µ f.
            v = np.cross(path.R[node, :, 2], -path.normal[node])
            v /= np.linalg.norm(v)
        F = np.concatenate([path.force[node] * (path.normal[node] - 0.3 * v), np.zeros(3)])
        tau = arm.M @ ddq + arm.h + arm.g - arm.J.T @ F
        np.testing.assert_allclose(found.speed[k], np.abs(dq) / model.velocity_limit, atol=2e-3)
        least = np.abs(tau) / np.minimum(model.effort_limit, where.limits.torque)
        more = np.abs(tau - arm.g) / where.limits.deviation
        np.testing.assert_allclose(found.torque[k], np.maximum(least, more), atol=5e-3)


def test_way_begins_where_a_job_begins_and_never_jumps() -> None:
    where = place()
    plan_strokes = [line(-0.01), line(0.01)]
    paths = [timed(stroke, where.placement, where.upright) for stroke in plan_strokes]
    legs = list(route(plan_strokes, paths, placement=where.placement, upright=where.upright, uncertainty=4e-3))
    ways = followed(where, legs)
    q = np.concatenate([way.q for way in ways])
    assert np.abs(np.diff(q, axis=0)).max() < 0.3
    assert np.abs(q[0] - HOME).max() < 2.0 * np.pi
    assert [leg.name for leg in legs][-3:] == ["the way to stroke 2", "stroke 2", "the rise after the last stroke"]


def test_a_stroke_that_is_planned_slower_than_the_recipe_says_is_told() -> None:
    strokes = (line(-0.01), replace(line(0.01), feed=np.linspace(0.02, 0.0051, 81)))
    (note,) = check(place(), strokes, Recipe()).notes
    assert note.startswith("1 of 2 strokes are planned slower than the recipe says, down to 5.1 mm/s")
    assert check(place(), strokes, Recipe(feed=0.0051)).notes == ()
