"""Plans that no arm can do, each refused with its reason before anything moves; and plans that it can do, not refused.

30 bad plans are drawn with a seed: the mould stands where it cannot be reached, or where the arm would fold, stretch or
run into something; the strokes ask for too much or lie elsewhere; the file lies. A plan counts when the refusal is the
one line that names the right reason, and no robot was written to. Then every bundled mould with every pattern at nine
placements has to pass.

    python benchmarks/finishing_checks.py [--short]
"""

from __future__ import annotations

import argparse
import json
import logging
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import text_table

from burnish.check.plan import check
from burnish.check.ways import Workplace
from burnish.core import Array, Command
from burnish.errors import InputError, PlanError
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import MOUNT, TURN, Placement, tool_down
from burnish.polish.plan_file import load_plan
from burnish.polish.planned import planned
from burnish.polish.recipe import Bounds, Pass, Recipe
from burnish.polish.recipe_file import PATTERNS
from burnish.rotation import exp
from burnish.runtime.limits import Limits
from burnish.sim.robot import SimRobot
from burnish.surface import DistanceGrid, Mould

MOULDS = ("mould", "dome", "wave", "plate")
NAMES = ("raster", "cross_hatch", "spiral", "contour", "geodesic")
"""Patterns that cover a mould; a drawn path is the user's own."""
SHIFT = 0.02
"""How far the nine placements lie apart [m]."""
UNCERTAINTY = 4e-3
"""Of where the surface is before it is found [m]."""


@dataclass(kw_only=True)
class Motion:
    """What was asked of any simulated robot."""

    writes: int = 0


@dataclass(frozen=True, kw_only=True)
class Bad:
    """A plan that has to be refused."""

    name: str
    """What is wrong with it."""
    reason: str
    """Regular expression of the refusal."""
    strokes: tuple[Stroke, ...]
    """Mould frame."""
    place: Workplace
    """Where it was to be done."""
    recipe: Recipe = field(default_factory=Recipe)
    """Its recipe."""
    text: str | None = None
    """The plan as a file; the strokes count where there is none."""


def block(*boxes: tuple[float, float, float, float, float], name: str = "block") -> Mould:
    """A mould of boxes on a plate: x, y, sides and height of each [m]."""
    corners = [_box(*one) for one in ((0.0, 0.0, 0.12, 0.06, 0.02), *boxes)]
    return Mould.of(name, np.concatenate(corners))


def line(y: float = 0.0, low: float = -0.02, high: float = 0.02, *, feed: float = 0.02, force: float = 10.0) -> Stroke:
    """A line along x on top of the block."""
    x = np.linspace(low, high, 81)
    level = np.ones_like(x)
    points = np.column_stack((x, y * level, 0.02 * level))
    return Stroke(points=points, normals=np.tile([0.0, 0.0, 1.0], (81, 1)), feed=feed * level, force=force * level)


def workplace(mould: Mould, grid: DistanceGrid, p: Array, R: Array, tool: PolishingTool) -> Workplace:
    """The arm with its tool, and a mould anywhere."""
    model = tool.on(Model.jaco2())
    return Workplace(
        model=model,
        limits=Limits.jaco2(),
        mould=mould,
        grid=grid,
        placement=Placement(p=p, R=R),
        upright=tool_down(model),
        uncertainty=UNCERTAINTY,
    )


def bad_plans(seed: int = 0) -> Iterator[Bad]:
    """The 30 plans of a seed."""
    rng = np.random.default_rng(seed)
    mould, tool = block(), PolishingTool()
    small = Mould.of("small", _box(0.0, 0.0, 0.06, 0.06, 0.02))
    grid = DistanceGrid.of(mould)
    good = (line(-0.01), line(0.01))
    there = MOUNT - np.array([0.0, 0.0, 0.02])

    def at(x: float = 0.0, y: float = there[1], z: float = there[2], turn: Array | None = None) -> Workplace:
        R = TURN if turn is None else exp(turn) @ TURN
        near = np.array([x, y, z]) + rng.uniform(-2e-3, 2e-3, 3)
        return workplace(mould, grid, near, R, tool)

    def with_tool(other: PolishingTool) -> tuple[Workplace, Recipe]:
        return workplace(mould, grid, there, TURN, other), Recipe(tool=other)

    def beside(*boxes: tuple[float, float, float, float, float]) -> Workplace:
        other = block(*boxes, name="block with more")
        return workplace(other, DistanceGrid.of(other), there, TURN, tool)

    def changed(**changes: Callable[[Stroke], Array]) -> tuple[Stroke, ...]:
        one = good[1]
        arrays: dict[str, Any] = {name: change(one) for name, change in changes.items()}
        return good[0], replace(one, **arrays)

    def one_point(values: Array, value: Any) -> Array:
        new = np.array(values)
        new[int(rng.integers(5, 75))] = value
        return new

    far, off = rng.uniform(0.0, 0.1), rng.uniform(1e-3, 3e-3)
    reach = r"out of the arm's reach|cannot bring its tool"
    yield Bad(name="too far away", reason=reach, strokes=good, place=at(y=-0.66 - far))
    yield Bad(name="too high", reason=reach, strokes=good, place=at(z=0.45 + far))
    yield Bad(name="far to the side", reason=reach, strokes=good, place=at(x=0.7 + far))
    yield Bad(name="lying on its side", reason=reach, strokes=good, place=at(y=-0.4, turn=np.array([-1.5, 0.0, 0.0])))
    yield Bad(name="arm folded", reason="joint 3 comes within", strokes=good, place=at(y=-0.10, z=0.1))
    strict = Recipe(limits=Bounds(joint_margin=0.78))
    yield Bad(
        name="margin of the recipe", reason="joint 3 comes within", strokes=good, place=at(y=-0.25), recipe=strict
    )
    yield Bad(name="arm stretched", reason="singular", strokes=good, place=at(y=-0.60))
    yield Bad(name="arm stretched sideways", reason="singular", strokes=good, place=at(x=0.5))
    near = workplace(small, DistanceGrid.of(small), np.array([0.0, -0.13, 0.2]), TURN, tool)
    yield Bad(name="hand at the upper arm", reason="upper arm .* hand", strokes=good, place=near)
    yield Bad(
        name="stand in the arm's base", reason="(base|shoulder|arm) .* stand", strokes=good, place=at(y=-0.10, z=0.27)
    )
    floor = at(y=-0.4, z=0.0, turn=np.array([0.0, 1.2, 0.0]))
    yield Bad(name="hand at the floor", reason="the floor", strokes=good, place=floor)
    tower = beside((0.05, 0.0, 0.02, 0.06, 0.2))
    yield Bad(name="tower beside the path", reason="(tool's body|hand|wrist) .* mould", strokes=good, place=tower)
    ridge = (line(0.0, -0.05, -0.03), line(0.0, 0.03, 0.05))
    post = beside((0.0, 0.0, 0.01, 0.04, 0.05 + far / 10.0))
    yield Bad(name="post on the way across", reason="the tip .* mould", strokes=ridge, place=post)
    place, recipe = with_tool(replace(tool, length=0.05, body_com=0.01))
    yield Bad(name="tool too short", reason="the hand runs into the mould", strokes=good, place=place, recipe=recipe)
    place, recipe = with_tool(replace(tool, body_radius=0.06))
    yield Bad(name="tool too thick", reason="tool's body runs into", strokes=good, place=place, recipe=recipe)
    slow = Recipe(limits=Bounds(joint_speed=0.1, least_feed=0.5))
    fast = tuple(line(y, feed=0.07) for y in (-0.01, 0.01))
    yield Bad(name="joints too fast", reason="feed .* too fast for the arm", strokes=fast, place=at(), recipe=slow)
    nod = changed(normals=lambda one: _nodding(one, 0.2))
    yield Bad(name="tool turned too fast", reason="turns the tool too fast", strokes=nod, place=at())
    weak = Recipe(limits=Bounds(joint_torque=0.3))
    hard = tuple(line(y, force=20.0) for y in (-0.01, 0.01))
    yield Bad(name="too much torque", reason="torque, pressing with 20 N", strokes=hard, place=at(y=-0.5), recipe=weak)
    place, recipe = with_tool(replace(tool, body_mass=2.0))
    recipe = replace(recipe, limits=Bounds(joint_torque=0.4))
    yield Bad(name="tool too heavy", reason="% of its torque", strokes=good, place=place, recipe=recipe)
    yield Bad(name="no strokes", reason="no strokes", strokes=(), place=at())
    above = changed(points=lambda one: one.points + [0.0, 0.0, off])
    yield Bad(name="above the surface", reason="above the surface", strokes=above, place=at())
    below = changed(points=lambda one: one.points - [0.0, 0.0, off])
    yield Bad(name="in the metal", reason="below the surface", strokes=below, place=at())
    inward = changed(normals=lambda one: -one.normals)
    yield Bad(name="normals inward", reason="points into the mould", strokes=inward, place=at())
    strong = changed(force=lambda one: one_point(one.force, 40.0))
    yield Bad(name="force out of range", reason="force 40 N is out of range", strokes=strong, place=at())
    quick = changed(feed=lambda one: one_point(one.feed, 0.5))
    yield Bad(name="feed out of range", reason=r"feed 0.5 m/s is out of range", strokes=quick, place=at())
    torn = changed(points=lambda one: one.points * np.where(one.points[:, :1] > 0.0, [1.5, 1.0, 1.0], [1.0, 1.0, 1.0]) +
                   np.where(one.points[:, :1] > 0.0, [0.01, 0.0, 0.0], [0.0, 0.0, 0.0]))  # fmt: skip
    yield Bad(name="path torn", reason="the path is torn", strokes=torn, place=at())
    plan = {"strokes": [_plain(one) for one in good], "mould": {"name": "block", "sha256": mould.sha256}}
    other = json.dumps(plan | {"mould": {"name": "block", "sha256": "0" * 64}})
    yield Bad(name="another mould", reason="made for a mould with", strokes=(), place=at(), text=other)
    nan = json.dumps(plan).replace('"feed": [0.02', '"feed": [NaN', 1)
    yield Bad(name="not a number", reason="the number NaN", strokes=(), place=at(), text=nan)
    short = json.dumps(plan | {"strokes": [_plain(good[0]) | {"force": [10.0]}]})
    yield Bad(name="lying file", reason="force has shape", strokes=(), place=at(), text=short)
    yield Bad(
        name="file cut off", reason="is no plan", strokes=(), place=at(), text=json.dumps(plan)[: -int(40 + 50 * off)]
    )


def refused(bad: Bad, motion: Motion) -> tuple[bool, str]:
    """Whether a plan was refused for the right reason with no motion, and what was said."""
    before = motion.writes
    try:
        strokes, made_for = list(bad.strokes), None
        if bad.text is not None:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "plan.json"
                path.write_text(bad.text)
                plan = load_plan(path)
            strokes, made_for = plan.strokes, plan.made_for
        check(bad.place, strokes, bad.recipe, made_for=made_for)
    except PlanError as error:
        said = str(error)
        right = re.search(bad.reason, said) is not None and "\n" not in said and motion.writes == before
        return right, said
    return False, "not refused"


def good_plans(short: bool) -> Iterator[tuple[str, str, Workplace, list[Stroke], Recipe]]:
    """Bundled moulds, patterns and placements that have to pass: name, where, and the plan."""
    for name in ("mould",) if short else MOULDS:
        mould = Mould.load(name)
        grid = DistanceGrid.of(mould)
        for pattern in NAMES[:1] if short else NAMES:
            recipe = Recipe(passes=(Pass(pattern=PATTERNS[pattern]()),))
            strokes = [stroke for one in planned(recipe, mould, grid) for stroke in one]
            top = max(float(stroke.points[:, 2].max()) for stroke in strokes)
            for dx, dy in [(0, 0)] if short else [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]:
                p = MOUNT + np.array([SHIFT * dx, SHIFT * dy, -top])
                place = workplace(mould, grid, p, TURN, recipe.tool)
                yield f"{name} {pattern}", f"{1e3 * p[0]:+.0f}, {1e3 * p[1]:+.0f} mm", place, strokes, recipe


@contextmanager
def counted() -> Iterator[Motion]:
    """Count the commands that any simulated robot is given meanwhile."""
    motion, write = Motion(), SimRobot.write

    def counting(robot: SimRobot, command: Command) -> Array:
        motion.writes += 1
        return write(robot, command)

    SimRobot.write = counting  # type: ignore[method-assign, assignment]
    try:
        yield motion
    finally:
        SimRobot.write = write  # type: ignore[method-assign]


def rows(short: bool) -> list[dict[str, Any]]:
    """The rows of the table: found, goal, unit, whether it is met."""
    logging.getLogger("burnish").setLevel(logging.ERROR)  # that the moulds made up here are made of pieces
    with counted() as motion:
        outcomes = [(bad, *refused(bad, motion)) for bad in bad_plans()]
    wrong = [f"{bad.name}: {said}" for bad, right, said in outcomes if not right]
    for one in wrong:
        print(one, file=sys.stderr)
    passed, longest, whole = 0, 0.0, 0.0
    missed: dict[str, list[str]] = {}
    for name, where, place, strokes, recipe in good_plans(short):
        start = time.process_time()
        try:
            check(place, strokes, recipe, made_for=place.mould.sha256)
            passed += 1
        except InputError as error:
            missed.setdefault(f"{name}: {error}", []).append(where)
            print(f"{name} at {where}: {error}", file=sys.stderr)
        spent = time.process_time() - start
        print(f"{name} at {where}: {spent:.1f} s", file=sys.stderr)
        longest = max(longest, spent if name.startswith("mould") else 0.0)
        whole += spent
    right = len(outcomes) - len(wrong)
    lost = sum(map(len, missed.values()))
    count = passed + lost
    causes = "; ".join(f"{cause} (at {len(places)} places)" for cause, places in missed.items())
    return [
        row("bad plans refused with the right reason, no motion", right, 30, "of 30", right == 30, "; ".join(wrong)),
        row("commands to a robot meanwhile", motion.writes, 0, "", motion.writes == 0, ""),
        row("good plans refused", lost, 0, f"of {count}", not missed, causes),
        row(
            "longest check of `mould`",
            round(longest, 2),
            3.0,
            "s of CPU",
            longest <= 3.0,
            f"mean {whole / count:.2f} s",
        ),
    ]


def row(name: str, found: float, goal: float, unit: str, met: bool, note: str) -> dict[str, Any]:
    """A row of the table."""
    return {"name": name, "found": found, "goal": goal, "unit": unit, "met": met, "note": note}


def _box(x: float, y: float, width: float, depth: float, height: float) -> Array:
    """Triangles of a box on the plane z = 0, (12, 3, 3)."""
    corner = np.array([(i, j, k) for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (0.0, 1.0)])
    vertices = np.array([x, y, 0.0]) + corner * [width, depth, height]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
             (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip
    return np.asarray(vertices[np.array(faces)])


def _nodding(stroke: Stroke, angle: float) -> Array:
    """Normals that swing to and fro by an angle from point to point of a stroke."""
    swing = angle * np.where(np.arange(len(stroke.points)) % 4 < 2, 1.0, -1.0)
    return np.column_stack((np.sin(swing), np.zeros_like(swing), np.cos(swing)))


def _plain(stroke: Stroke) -> dict[str, Any]:
    """A stroke in plain lists."""
    return {name: getattr(stroke, name).tolist() for name in ("points", "normals", "feed", "force")}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--short", action="store_true", help="one good plan instead of 180")
    parser.add_argument("--out", type=Path, help="file for the rows, JSON")
    options = parser.parse_args()
    found = rows(options.short)
    lines = [[str(one[key]) for key in ("name", "found", "goal", "unit", "met", "note")] for one in found]
    print(text_table(["row", "found", "goal", "unit", "met", "note"], lines))
    if options.out:
        options.out.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
