"""Removal: what the model costs and how true it is, how even a plan with fitted feeds is, run, and repaired.

python benchmarks/finishing_removal.py [--short]

The tool spins at 300 rad/s and leans by 15° across its lines, so the feed sets the depth. The short form plans only,
the full one runs them on five honest arms as well, which hold the tool so, with the drag of its spindle in the contact,
and judges the worst. The mould is looked for by touches all round it, as `burnish polish --search` does.
Preston's k is a placeholder; every percentage is free of it.
"""

from __future__ import annotations

import os

# Before NumPy is loaded: BLAS reads its threads then.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from burnish.commands.course import BESIDE
from burnish.commands.evaluate import rubbed
from burnish.core import Array, Sample
from burnish.finish.dwell import Dwell
from burnish.finish.removal import Coverage, Removal, coverage, workable
from burnish.finish.repair import repair
from burnish.finish.rubbing import Spindle
from burnish.model.ik import inverse_kinematics
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import contact_radius, recommended_step
from burnish.paths.lead import with_leads
from burnish.paths.patterns import Raster
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.paths.tilt import Tilt
from burnish.polish.cell import READY, Placement, nominal_placement
from burnish.polish.cellsim import WristFelt, simulated_job
from burnish.polish.moves import Moves, nearest_turn
from burnish.polish.recipe import EDGE_BAND, MARGIN, PRESTON, Recipe
from burnish.polish.search import Wide
from burnish.sim import arms
from burnish.sim.truth import Truth
from burnish.surface import DistanceGrid, Mould, WorkingSurface
from burnish.surface.bundled import block

FORCE, FEED = 10.0, 0.02
RATE, LEAN = 300.0, float(np.deg2rad(15.0))
LEAD = 10e-3
"""Over which the force rises and falls at the ends of a stroke [m]."""
MOULDS = ("plate", "dome", "wave", "mould")
SEEDS = (1, 2, 3, 4, 5)
TOOL = PolishingTool(spindle=RATE)
RECIPE = Recipe(force=FORCE, feed=FEED, tool=TOOL)
TILT = Tilt(angle=LEAN, heading=0.5 * np.pi)
LAW = Removal(coefficient=PRESTON, tip_radius=TOOL.tip_radius, modulus=TOOL.modulus)
SPINDLE = Spindle(rate=RATE, tip_radius=TOOL.tip_radius)
RADIUS = float(contact_radius(FORCE, TOOL.tip_radius, 0.0, TOOL.modulus))
DWELL = Dwell(law=LAW, spindle=SPINDLE)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A mould, a path over it, and what judges it."""

    mould: Mould
    grid: DistanceGrid
    surface: WorkingSurface
    counted: Any
    strokes: list[Stroke]
    target: float
    """Depth of one pass [m]: that of the recipe's feed, or more where the arm cannot be that fast everywhere."""

    @classmethod
    def of(cls, name: str) -> Bench:
        """A bundled mould under the tool of the cell."""
        mould = Mould.load(name)
        grid = DistanceGrid.of(mould)
        inner, reach = (
            Reach.of(mould, grid, tip_radius=TOOL.tip_radius, margin=margin, modulus=TOOL.modulus)
            for margin in (EDGE_BAND, MARGIN)
        )
        surface = WorkingSurface.of(mould, LAW.edge(FORCE))
        counted = workable(surface, inner)
        found = Raster().strokes(reach, mould, step=None, feed=FEED, force=FORCE)
        strokes = [replace(with_leads(stroke, LEAD), tilt=TILT) for stroke in found]
        step = recommended_step(FORCE, TOOL.tip_radius, 0.0, TOOL.modulus)
        recipe = PRESTON * FORCE * SPINDLE.speed(RADIUS, LEAN) / (FEED * step)
        target = max(recipe, DWELL.least(surface, strokes, counted))
        return cls(mould=mould, grid=grid, surface=surface, counted=counted, strokes=strokes, target=target)

    def judged(self, depth: Array) -> Coverage:
        """Over what counts."""
        return coverage(depth, self.target, self.surface.areas, self.counted)

    def fitted(self) -> list[Stroke]:
        """The path with the feed that removes the target."""
        return DWELL.fitted(self.surface, self.strokes, np.full(len(self.counted), self.target), self.counted)

    def run(
        self, strokes: list[Stroke], seed: int, stands: Placement, known: Placement | None
    ) -> tuple[Array, Placement, str]:
        """Depth that an honest arm removes, where it found the mould, and how it ended."""
        job, robot = simulated_job(
            DistanceGrid.of(self.mould, aside=BESIDE),
            strokes,
            arms.honest(seed),
            rate=100.0,
            felt=WristFelt(),
            tool=TOOL,
            on_phase=lambda phase: None,
            stands=stands,
            finder=Wide() if known is None else lambda moves: at_known(moves, known),
        )
        with robot:
            for _ in job.run():
                pass
        event = job.rig.supervisor.event
        ending = job.failure or (event.cause if event else "done")
        return self.removed(robot.truth), job.placement, ending

    def removed(self, truth: Truth) -> Array:
        """Preston's depth of the true contact under the leaning spindle [m], (V,)."""
        on = np.isfinite(np.asarray(truth.point)[:, 0])
        dt = np.diff(np.concatenate([[0.0], truth.time]))[on]
        return LAW.depth_of(self.surface, rubbed(truth, self.surface, RECIPE, TOOL), dt)


def at_known(moves: Moves, known: Placement) -> Iterator[Sample]:
    """Go over a mould that was found before and has not moved since."""
    moves.placement, moves.uncertainty = known, 1e-3
    over = known.points(moves.strokes[0].points[:1])[0] + 0.05 * UP
    q = inverse_kinematics(moves.rig.model, over, moves.upright, READY)
    yield from moves.joints(nearest_turn(moves.rig.model.lower, moves.home, q))


def worn(stroke: Stroke) -> Stroke:
    """A stroke that presses with 40 % over a disc of 18 mm radius, and with three quarters beyond x = −30 mm."""
    x, y = stroke.points[:, 0], stroke.points[:, 1]
    share = np.where(np.hypot(x - 0.015, y - 0.010) < 0.018, 0.4, 1.0) * np.where(x < -0.03, 0.75, 1.0)
    return replace(stroke, force=share * stroke.force)


def row(name: str, found: float, goal: float, unit: str, note: str = "", at_least: bool = False) -> dict[str, Any]:
    """A row of the table."""
    met = bool(found >= goal if at_least else found <= goal)
    return {"name": name, "found": float(found), "goal": goal, "unit": unit, "met": met, "note": note}


def tracks(step: float, spacing: float = 0.2e-3) -> tuple[Array, Array]:
    """Points of parallel lines over a slab of 80 × 60 mm, and the time at each."""
    x = np.arange(-0.05, 0.05, spacing)
    points = np.concatenate([np.column_stack((x, 0 * x + y, 0 * x + 0.01)) for y in np.arange(-0.03, 0.03, step)])
    return points, np.full(len(points), spacing / FEED)


def model_rows() -> list[dict[str, Any]]:
    """Cost of a map, and the model against the text-book depth, spinning or not, on two meshes."""
    plate = WorkingSurface.of(Mould.load("plate"), 0.9e-3)
    x, y = np.meshgrid(np.arange(-0.09, 0.09, 0.2e-3), np.arange(-0.09, 0.09, 2.5e-3))
    points = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, 0.02)))
    one = np.ones(len(points))
    normals = np.tile(UP, (len(points), 1))
    cost = np.inf
    for _ in range(3):
        start = time.process_time()
        LAW.depth(plate, contacts=points, normals=normals, force=FORCE * one, speed=FEED * one, dt=0.01 * one)
        cost = min(cost, 1e6 * (time.process_time() - start) / len(points))
    ticks = (np.array([-0.04, 0.04]), np.array([-0.03, 0.03]))
    slab = Mould.of("slab", block(*ticks, lambda u, v: np.full_like(u, 0.01)))
    off, change, step = [], [], 2e-3
    points, dt = tracks(step)
    for spindle, lean in ((Spindle(rate=0.0, tip_radius=TOOL.tip_radius), 0.0), (SPINDLE, 0.0), (SPINDLE, LEAN)):
        means = []
        for fineness in (1.0, 2.0, 3.0):
            surface = WorkingSurface.of(slab, LAW.edge(FORCE) / fineness)
            rubbing = spindle.rubbing(
                contacts=points,
                normals=np.tile(UP, (len(points), 1)),
                force=np.full(len(points), FORCE),
                velocity=np.tile([FEED, 0.0, 0.0], (len(points), 1)),
                axes=np.tile([-np.sin(lean), 0.0, -np.cos(lean)], (len(points), 1)),
            )
            inner = (np.abs(surface.vertices[:, 0]) < 0.02) & (np.abs(surface.vertices[:, 1]) < 0.012)
            means.append(coverage(LAW.depth_of(surface, rubbing, dt), 1e-9, surface.areas, inner).mean)
        speed = spindle.speed(RADIUS, lean) or FEED
        off += [100.0 * abs(mean / (PRESTON * FORCE * speed / (FEED * step)) - 1.0) for mean in means]
        change.append(100.0 * float(np.ptp(means)) / means[0])
    note = "without spindle, spinning upright, spinning and leant by 15°"
    return [
        row(
            "removal map, cost of a sample",
            cost,
            50.0,
            "µs",
            f"{len(plate.vertices)} vertices, 100 Hz at 20 mm/s, processor time",
        ),
        row("removal against h = k F v/(feed step)", max(off), 2.0, "%", f"three meshes; {note}"),
        row("removal, change on refinement", max(change), 1.0, "%", f"sides a/3, a/6, a/9; {note}"),
    ]


def planned_rows(name: str, bench: Bench, fitted: list[Stroke], seconds: float) -> list[dict[str, Any]]:
    """Evenness with the fitted and with a constant feed, and a repair of worn places."""
    length = sum(stroke.length for stroke in bench.strokes)
    time_ = sum(float(np.trapezoid(1.0 / stroke.feed, stroke.arc)) for stroke in fitted)
    level = [replace(stroke, feed=np.full(len(stroke.feed), length / time_)) for stroke in bench.strokes]
    constant = bench.judged(DWELL.depth(bench.surface, level))
    plan = bench.judged(DWELL.depth(bench.surface, fitted))
    depth = DWELL.depth(bench.surface, [worn(stroke) for stroke in fitted])
    mended = repair(DWELL, bench.surface, fitted, depth, bench.target, bench.counted)
    before, after = bench.judged(depth), bench.judged(depth + DWELL.depth(bench.surface, mended.strokes))
    note = f"{constant.cv_pct:.1f} % at a constant feed in the same time; fitted in {seconds:.1f} s"
    said = f"from {before.cv_pct:.1f} %; {mended.zones} zones, {len(mended.strokes)} strokes"
    return [
        row(f"planned removal CV with fitted feed, {name}", plan.cv_pct, 6.0, "%", note),
        row(f"planned removal CV, fitted over constant feed, {name}", plan.cv_pct / constant.cv_pct, 1.0, "", note),
        row(f"planned coverage with fitted feed, {name}", plan.covered_pct, 98.0, "%", "", True),
        row(f"planned over-polished with fitted feed, {name}", plan.overpolished_pct, 3.0, "%"),
        row(f"removal CV after a planned repair of worn places, {name}", after.cv_pct, 8.0, "%", said),
        row(f"coverage after a planned repair of worn places, {name}", after.covered_pct, 98.0, "%", said, True),
    ]


@lru_cache(maxsize=1)
def prepared(name: str) -> tuple[Bench, list[Stroke], float]:
    """The bench of a mould, its path with the fitted feed, and how long the fit took [s]."""
    bench = Bench.of(name)
    start = time.perf_counter()
    fitted = bench.fitted()
    return bench, fitted, time.perf_counter() - start


def executed(name: str, seed: int) -> tuple[Coverage, Coverage, str, str]:
    """What an honest arm leaves when it runs the plan, and after a repair of that; how both went."""
    bench, fitted, _ = prepared(name)
    stands = nominal_placement(float(np.concatenate([stroke.points for stroke in fitted])[:, 2].max()))
    depth, found, ending = bench.run(fitted, seed, stands, None)
    done = bench.judged(depth)
    mended = repair(DWELL, bench.surface, fitted, depth, bench.target, bench.counted)
    if mended.strokes:
        more, _, how = bench.run(list(mended.strokes), seed, stands, found)
        depth = depth + more
    else:
        how = "nothing to do"
    return done, bench.judged(depth), ending, f"{mended.zones} zones, {len(mended.strokes)} strokes, {how}"


def executed_rows(name: str) -> list[dict[str, Any]]:
    """The worst of the honest arms, each by itself, as it was left and after one repair."""
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        runs = list(zip(SEEDS, pool.map(executed, [name] * len(SEEDS), SEEDS), strict=True))
    seed, (done, _, ending, _) = max(runs, key=lambda run: run[1][0].cv_pct)
    mended, (_, after, _, how) = max(runs, key=lambda run: run[1][1].cv_pct)
    least, (_, covered, _, _) = min(runs, key=lambda run: run[1][1].covered_pct)

    def every(judged: Iterable[Coverage]) -> str:
        return "of all seeds " + ", ".join(f"{one.cv_pct:.1f}" for one in judged)

    return [
        row(f"executed removal CV, {name}", done.cv_pct, 12.0, "%",
            f"seed {seed}, {ending}; " + every(run[0] for _, run in runs)),
        row(f"removal CV after one executed repair, {name}", after.cv_pct, 8.0, "%",
            f"seed {mended}, {how}; " + every(run[1] for _, run in runs)),
        row(f"coverage after one executed repair, {name}", covered.covered_pct, 98.0, "%", f"seed {least}", True),
    ]  # fmt: skip


def rows(short: bool) -> list[dict[str, Any]]:
    """The rows of the table; short: planned only, dome and wave."""
    found = model_rows()
    for name in MOULDS[1:3] if short else MOULDS:
        found += planned_rows(name, *prepared(name))
        if not short:
            found += executed_rows(name)
    return found


def main() -> int:
    """Print the rows, one a line; 0 if all are met, 1 if not."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("--short", action="store_true", help="planned only, dome and wave")
    options = cli.parse_args()
    found = rows(options.short)
    for one in found:
        print(json.dumps(one, ensure_ascii=False))
    return 0 if all(one["met"] for one in found) else 1


if __name__ == "__main__":
    raise SystemExit(main())
