"""The thesis's own way of polishing against ours: same arm, tool, mould, tool path and approach.

The thesis presses by sinking the reference of a plain impedance law below the surface, without force feedback.
Between the strokes (approach, touch, lift) both arms are driven by our law; along the strokes each by its own.
Force errors are those of the true contact force, from one second after the force ramp on.
"""

from __future__ import annotations

import os

# Before NumPy is loaded: BLAS reads its threads then.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import comma_numbers, machine, pieces_of, text_table, write_json

from burnish.commands.evaluate import RunLog, evaluate
from burnish.control.force import ForceMotion
from burnish.core import Array, Dynamics, ToolReference
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import recommended_step
from burnish.paths.raster import raster
from burnish.paths.stroke import Stroke
from burnish.polish.cellsim import WristFelt, simulated_job
from burnish.polish.recipe import MARGIN, Recipe
from burnish.rotation import quaternion_error
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.surface import DistanceGrid, Mould

GOAL = 4.0
"""Ours must have a force RMS at least so many times lower, worst seed against worst seed."""
HIGHER_LIMIT = 100.0
"""Tool force at which the supervisor stops the baseline when its usual limit has stopped it once [N]."""
INSET = 8e-3
"""Of the path from the border [m]. The thesis's soft spring lets the tool lag and lean by several degrees: where ours
still rubs, 3 mm from the border of the dome, it slides off the part, and then has no force error of any meaning."""
FIGURES = ("force_rms_N", "force_p99_N", "force_mean_N", "contact_lost_pct", "tilt_rms_deg", "tilt_max_deg")


@dataclass(frozen=True, kw_only=True)
class SunkImpedance:
    """Impedance without force sensing, its reference sunk below the surface: ``τ = Jᵀ w + g``.

        w = [K (p_s − p) + D (ṗ_d − ṗ); K_o ε + D_o (ω_d − ω)],   p_s = p_d − (F/K) z

    with ε the vector part of the error quaternion and z up along the base. Sunk by F/K the spring presses with F
    if nothing else acts. Source: thesis B, eq. 4.19–4.21, and for the way of pressing and the gains section 6.2,
    table 6.1; the thesis does not say how deep it sinks the reference, F/K is the choice that favours it most.
    """

    stiffness: float = 200.0
    """K [N/m]."""
    damping: float = 24.0
    """D [N·s/m]."""
    turning_stiffness: float = 9.5
    """K_o [N·m]; ε is about half of the angle."""
    turning_damping: float = 1.2
    """D_o [N·m·s/rad]."""

    def reset(self, arm: Dynamics) -> None:
        """No memory."""

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        slip = reference.v - arm.v
        sunk = reference.p - np.array([0.0, 0.0, reference.force / self.stiffness])
        force = self.stiffness * (sunk - arm.p) + self.damping * slip[:3]
        moment = self.turning_stiffness * quaternion_error(arm.R, reference.R) + self.turning_damping * slip[3:]
        return np.asarray(arm.J.T @ np.concatenate([force, moment]) + arm.g)


@dataclass(frozen=True, kw_only=True)
class AlongStrokes:
    """One law where the reference has a surface under it, another one everywhere else."""

    stroke: SunkImpedance
    air: ForceMotion

    def reset(self, arm: Dynamics) -> None:
        """Reset both."""
        self.stroke.reset(arm)
        self.air.reset(arm)

    def torque(self, arm: Dynamics, reference: ToolReference) -> Array:
        """Joint torques [N·m], (n,), gravity included."""
        law = self.air if reference.normal is None else self.stroke
        return law.torque(arm, reference)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """What both ways have in common."""

    mould: Mould
    grid: DistanceGrid
    recipe: Recipe
    tool: PolishingTool
    strokes: list[Stroke]
    rate: float

    def run(self, seed: int, thesis: bool, tool_force: float | None = None) -> dict[str, Any]:
        """The figures of one run; ``tool_force`` replaces the supervisor's limit [N]."""
        log = RunLog()
        arm = arms.honest(seed)
        job, robot = simulated_job(
            self.grid,
            self.strokes,
            arm,
            rate=self.rate,
            felt=WristFelt(),
            tool=self.tool,
            on_phase=lambda phase: log.phases.append((robot.time, phase)),
        )
        supervisor = job.rig.supervisor
        if tool_force is not None:
            # Anew: the guards have the limits that they were made with.
            limits = replace(supervisor.limits, tool_force=tool_force)
            supervisor = job.rig.supervisor = Supervisor(limits=limits, period=supervisor.period)
        if thesis:
            job.law = AlongStrokes(stroke=SunkImpedance(), air=job.law)  # type: ignore[assignment]
        with robot:
            for sample in job.run():
                log.add(sample)
        found = evaluate(log, robot.truth, self.mould, self.grid, self.recipe, self.tool, job.placement.R).metrics
        event = supervisor.event
        return {name: found[name] for name in FIGURES if name in found} | {
            "seed": seed,
            "supervisor": None if event is None else event.cause,
            "failure": job.failure,
            "tool_force_limit_N": supervisor.limits.tool_force,
            "duration_s": robot.time,
        }

    def baseline(self, seed: int) -> dict[str, Any]:
        """The thesis's way; if the supervisor ends it for its tool force, once more with a higher limit."""
        first = self.run(seed, thesis=True)
        if first["supervisor"] is None or "tool force" not in first["supervisor"]:
            return first
        return self.run(seed, thesis=True, tool_force=HIGHER_LIMIT) | {"stopped_first": first["supervisor"]}


def whole(run: dict[str, Any]) -> bool:
    """Whether a run got to its end and has figures; a tool that slid off the part has a force error of no meaning."""
    return run["supervisor"] is None and run["failure"] is None and "force_rms_N" in run


def worst_ratio(ours: list[dict[str, Any]], thesis: list[dict[str, Any]]) -> tuple[float | None, int]:
    """Force RMS of the worst seed, thesis over ours, and of how many seeds: those that both ways ended whole."""
    pairs = [
        (our["force_rms_N"], its["force_rms_N"])
        for our, its in zip(ours, thesis, strict=True)
        if whole(our) and whole(its)
    ]
    if not pairs:
        return None, 0
    return max(its for _, its in pairs) / max(our for our, _ in pairs), len(pairs)


def table(ours: list[dict[str, Any]], thesis: list[dict[str, Any]]) -> str:
    """A row a run."""

    def note(run: dict[str, Any]) -> str:
        notes = []
        if "stopped_first" in run:
            notes.append(f"stopped ({run['stopped_first']}), run again with {run['tool_force_limit_N']:.0f} N")
        if run["supervisor"] or run["failure"]:
            notes.append(f"ended early, does not count: {run['supervisor'] or run['failure']}")
        return "; ".join(notes) or "-"

    names = ("force_rms_N", "force_p99_N", "force_mean_N", "contact_lost_pct", "tilt_rms_deg")
    rows = [
        [way, str(run["seed"]), *(f"{run[n]:.2f}" if n in run else "-" for n in names), note(run)]
        for way, runs in (("ours", ours), ("thesis", thesis))
        for run in runs
    ]
    return text_table(
        ["way", "seed", "RMS [N]", "p99 [N]", "mean [N]", "lost [%]", "tilt RMS [deg]", "supervisor"], rows
    )


def parser() -> argparse.ArgumentParser:
    """The options."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--mould", default="dome", metavar="NAME|FILE.stl", help="what to work (default: dome)")
    options.add_argument("--force", type=float, default=10.0, metavar="N", help="set force [N] (default: 10)")
    options.add_argument("--feed", type=float, default=0.02, metavar="M/S", help="feed [m/s] (default: 0.02)")
    options.add_argument("--rate", type=float, default=100.0, metavar="HZ", help="control rate [Hz] (default: 100)")
    options.add_argument(
        "--seeds", type=comma_numbers, default=[1, 2, 3, 4, 5], metavar="LIST", help="as 1,2 or 1-5 (default: 1-5)"
    )
    options.add_argument(
        "--strokes",
        type=int,
        default=5,
        metavar="N",
        help="pieces of the path, spread over the part, each two lines and the turn between, 2 or more (default: 5)",
    )
    options.add_argument("--full", action="store_true", help="the whole tool path instead, with its turns")
    options.add_argument(
        "--margin",
        type=float,
        default=1e3 * INSET,
        metavar="MM",
        help=f"inset of the path from the border [mm]; more of it keeps a tool on the part that lags far behind "
        f"(default: {1e3 * INSET:g}; 'burnish polish' has {1e3 * MARGIN:g})",
    )
    options.add_argument(
        "--out", type=Path, metavar="FILE.json", help="file for the result in JSON (default: table on stdout only)"
    )
    return options


def main() -> int:
    """Run both ways; 0 if the goal is reached, 1 if not."""
    cli = parser()
    options = cli.parse_args()
    if options.strokes < 2:
        cli.error(f"--strokes {options.strokes}: the mould is located by touching the pieces; expected 2 or more")
    recipe, tool = Recipe(force=options.force, feed=options.feed), PolishingTool()
    mould = Mould.load(options.mould, "mm")
    grid = DistanceGrid.of(mould)
    strokes = raster(
        mould,
        grid,
        tip_radius=tool.tip_radius,
        step=recommended_step(recipe.force, tool.tip_radius, 0.0, tool.modulus),
        feed=recipe.feed,
        force=recipe.force,
        margin=1e-3 * options.margin,
    )
    if not options.full:
        strokes = pieces_of(strokes, options.strokes)
    cell = Cell(mould=mould, grid=grid, recipe=recipe, tool=tool, strokes=strokes, rate=options.rate)
    length = sum(stroke.length for stroke in strokes)
    print(f"{mould.name}: {len(strokes)} strokes, {length:.2f} m, {options.force:g} N, {1e3 * options.feed:g} mm/s")
    ours: list[dict[str, Any]] = []
    thesis: list[dict[str, Any]] = []
    for seed in options.seeds:
        for way, runs in (("ours", ours), ("thesis", thesis)):
            start = time.perf_counter()
            runs.append(cell.run(seed, thesis=False) if runs is ours else cell.baseline(seed))
            figure = runs[-1].get("force_rms_N")
            said = "nothing to score" if figure is None else f"force RMS {figure:.2f} N"
            print(f"seed {seed}, {way}: {said} ({time.perf_counter() - start:.0f} s)", file=sys.stderr, flush=True)
    ratio, counted = worst_ratio(ours, thesis)
    met = ratio is not None and ratio >= GOAL and all(whole(run) for run in ours)
    print(table(ours, thesis))
    said = "cannot be said" if ratio is None else f"{ratio:.1f}"
    print(
        f"force RMS of the worst seed, thesis over ours: {said} ({counted} of {len(ours)} seeds count); "
        f"goal at least {GOAL:g}: {'met' if met else 'missed'}"
    )
    if options.out:
        recorded = {"mould": mould.name, "force_N": options.force, "feed_m_s": options.feed, "rate_Hz": options.rate}
        recorded |= {"strokes": len(strokes), "path_length_m": length, "margin_mm": options.margin}
        result = {"ours": ours, "thesis": thesis, "ratio": ratio, "seeds_counted": counted, "goal": GOAL, "met": met}
        write_json(options.out, {"recipe": recorded, "machine": machine()} | result)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
