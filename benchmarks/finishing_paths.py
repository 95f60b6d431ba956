"""What a planned path would do if arm and force were perfect: coverage, evenness, air moves, distance from the surface.

python benchmarks/finishing_paths.py [--short]

The depth is Preston's under a spherical tip whose contact follows the local curvature, over the vertices that the tip
can reach outside the edge band; feed and force are those of the strokes. The target is that of the flat step at the
whole force, as in the report of a run. Only the patterns that suit a mould count; the others stand in the notes.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from burnish.core import Array
from burnish.finish.curvature import mean_curvature
from burnish.finish.removal import Coverage, Removal, coverage, workable
from burnish.model.tool import PolishingTool
from burnish.paths.hertz import contact_radius, recommended_step
from burnish.paths.order import air_way, ordered
from burnish.paths.patterns import Contour, CrossHatch, Geodesic, Pattern, Raster, Spiral
from burnish.paths.reach import Reach
from burnish.paths.stroke import Stroke
from burnish.polish.recipe import EDGE_BAND, MARGIN, PRESTON
from burnish.surface import DistanceGrid, Mould, WorkingSurface

FORCE, FEED = 10.0, 0.02
"""Of the recipe [N], [m/s]."""

PASSES: dict[str, int] = {"cross-hatch": 2}
"""Times that a pattern covers everything, where that is not once."""

PATTERNS: dict[str, Pattern] = {
    "raster": Raster(),
    "raster at 30°": Raster(angle=np.pi / 6.0),
    "cross-hatch": CrossHatch(),
    "spiral": Spiral(),
    "contour": Contour(),
    "geodesic": Geodesic(),
}

SUITED = {
    "plate": ("raster", "raster at 30°", "cross-hatch", "spiral", "geodesic"),
    "dome": ("raster", "raster at 30°", "cross-hatch", "spiral", "geodesic"),
    "wave": ("raster", "raster at 30°", "cross-hatch", "geodesic"),
    "mould": ("raster", "cross-hatch"),
}
"""Patterns that a planner would choose. Contours meet themselves along the bisectors of corners and holes, and geodesic
lines fan out behind a hole."""

SAMPLED = 23
"""Every so many points are compared with the triangles; they lie half a millimetre apart."""


@dataclass(frozen=True, kw_only=True)
class Planned:
    """A path and what it would do."""

    strokes: list[Stroke]
    judged: Coverage
    """Over what the tip reaches outside the edge band."""
    off_surface: float
    """Largest distance of a point of contact from the triangles [m]."""
    seconds: float
    """Time that planning took."""

    @property
    def saving(self) -> float:
        """Share of the air way that the order saves."""
        given = air_way(self.strokes)
        return 1.0 - air_way(ordered(self.strokes)) / given if given > 0.0 else 0.0


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A mould with all that judges a path over it."""

    mould: Mould
    reach: Reach
    law: Removal
    surface: WorkingSurface
    counted: NDArray[np.bool_]
    """Vertices that count, (V,)."""
    target: float
    """[m]."""

    @classmethod
    def of(cls, name: str) -> Bench:
        """A bundled mould under the tool of the cell."""
        tool, mould = PolishingTool(), Mould.load(name)
        grid = DistanceGrid.of(mould)
        inner, reach = (
            Reach.of(mould, grid, tip_radius=tool.tip_radius, margin=margin, modulus=tool.modulus)
            for margin in (EDGE_BAND, MARGIN)
        )
        law = Removal(coefficient=PRESTON, tip_radius=tool.tip_radius, modulus=tool.modulus)
        surface = WorkingSurface.of(mould, law.edge(FORCE))
        return cls(
            mould=mould,
            reach=reach,
            law=law,
            surface=surface,
            counted=workable(surface, inner),
            target=PRESTON * FORCE / recommended_step(FORCE, tool.tip_radius, 0.0, tool.modulus),
        )

    def planned(self, pattern: Pattern, passes: int) -> Planned:
        """Plan and judge."""
        start = time.perf_counter()
        strokes = pattern.strokes(self.reach, self.mould, step=None, feed=FEED, force=FORCE)
        seconds = time.perf_counter() - start
        depth = sum(self._depth(stroke) for stroke in strokes)
        points = np.concatenate([stroke.points for stroke in strokes])[::SAMPLED]
        # In millimetres: in metres trimesh takes small triangles for points, and is wrong by 0.2 mm.
        mesh = trimesh.Trimesh(1e3 * self.mould.vertices, self.mould.faces, process=False)
        off = trimesh.proximity.closest_point(mesh, 1e3 * points)[1]  # type: ignore[no-untyped-call]
        return Planned(
            strokes=strokes,
            judged=coverage(np.asarray(depth), passes * self.target, self.surface.areas, self.counted),
            off_surface=1e-3 * float(off.max()),
            seconds=seconds,
        )

    def _depth(self, stroke: Stroke) -> Array:
        radius = float(contact_radius(FORCE, self.law.tip_radius, 0.0, self.law.modulus))
        return self.law.depth(
            self.surface,
            contacts=stroke.points,
            normals=stroke.normals,
            force=stroke.force,
            speed=stroke.feed,
            dt=np.gradient(stroke.arc) / stroke.feed,
            curvature=mean_curvature(self.surface, stroke.points, stroke.normals, radius),
        )


def rows(short: bool) -> list[dict[str, object]]:
    """The rows of the table; short: rasters of dome and mould only."""
    moulds = ("dome", "mould") if short else tuple(SUITED)
    names = ("raster",) if short else tuple(PATTERNS)
    found: list[dict[str, object]] = []
    every: dict[str, Planned] = {}
    for mould in moulds:
        bench = Bench.of(mould)
        plans = {name: bench.planned(PATTERNS[name], PASSES.get(name, 1)) for name in names}
        every |= {f"{name} on {mould}": plan for name, plan in plans.items()}
        suited = [name for name in names if name in SUITED[mould]]
        judged = {name: plan.judged for name, plan in plans.items()}
        for title, field, goal, worst in (
            ("planned coverage", "covered_pct", 98.0, min),
            ("planned over-polished", "overpolished_pct", 3.0, max),
            ("planned removal CV", "cv_pct", 6.0, max),
        ):
            value = worst(getattr(judged[name], field) for name in suited)
            met = value >= goal if worst is min else value <= goal
            others = ", ".join(
                f"{name} {getattr(one, field):.1f}" + ("" if name in suited else " (unsuited)")
                for name, one in judged.items()
            )
            found.append(_row(f"{title}, {mould}", value, goal, "%", met, others))
    off = {name: 1e3 * plan.off_surface for name, plan in every.items()}
    furthest = max(off, key=lambda name: off[name])
    found.append(_row("waypoints off the surface", off[furthest], 0.05, "mm", off[furthest] <= 0.05, furthest))
    several = {name: 100.0 * plan.saving for name, plan in every.items() if len(plan.strokes) > 2}
    note = ", ".join(f"{name} {value:.0f} ({len(every[name].strokes)})" for name, value in several.items())
    saving = float(np.mean(list(several.values()))) if several else 0.0
    least = min(several.values(), default=0.0)
    found.append(_row("air way saved by the order, mean", saving, 0.0, "%", least >= 0.0, f"% (strokes): {note}"))
    slowest = max(every, key=lambda name: every[name].seconds)
    seconds = every[slowest].seconds
    found.append(_row("planning a pattern", seconds, 10.0, "s", seconds <= 10.0, slowest))
    return found


def _row(name: str, value: float, goal: float, unit: str, met: bool, note: str) -> dict[str, object]:
    return {"name": name, "found": float(value), "goal": goal, "unit": unit, "met": bool(met), "note": note}


def main() -> None:
    """Print the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="rasters of dome and mould only")
    for row in rows(parser.parse_args().short):
        print(json.dumps(row, ensure_ascii=False))


if __name__ == "__main__":
    main()
