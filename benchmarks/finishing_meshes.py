"""Damaged meshes in, paths out: every waypoint must lie on the true surface and every normal point outward.

Dome and wave are judged by their formulas, the free-form mould by the triangles of its sound file, the box that some
spoilers add by its own. Each damaged file is loaded and planned as `burnish plan` does it, without telling the unit.
The second table is the time and memory of a mesh of up to a million triangles, each in a process of its own.

    python benchmarks/finishing_meshes.py --short
"""

from __future__ import annotations

import argparse
import json
import logging
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from common import machine, text_table, write_json
from finishing_defects import DEFECTS, Defect, stl

from burnish.core import Array
from burnish.errors import BurnishError, MouldError
from burnish.paths.raster import raster
from burnish.paths.stroke import Stroke
from burnish.polish.recipe import MARGIN
from burnish.surface import DistanceGrid, Mould, bundled
from burnish.surface.nearest import Nearest
from burnish.surface.winding import face_vectors

OFF_MM, TURNED_DEG = 0.05, 5.0
"""How far a waypoint may lie off the true surface, and a normal from the true one. The former is asked for; the latter
is a choice: the tool is as round as it was, and 5° of tilt is what a polisher gives it on purpose."""
TIP, STEP, FEED, FORCE = 15e-3, 2.3e-3, 0.02, 10.0
"""Tool and recipe in SI units, as by default."""
SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
"""Triangles of the meshes that are timed."""

Exact = Callable[[Array], tuple[Array, Array]]
"""Distance of points (N, 3) from the true surface [m], (N,), and the outward normals there, (N, 3)."""


def on_dome(points: Array) -> tuple[Array, Array]:
    """The bundled dome by its formula."""
    centre = np.array([0.0, 0.0, float(bundled.dome_height(np.zeros(1), np.zeros(1))[0]) - bundled.DOME_RADIUS])
    to = points - centre
    length = np.linalg.norm(to, axis=1)
    return np.abs(length - bundled.DOME_RADIUS), to / length[:, None]


def on_wave(points: Array) -> tuple[Array, Array]:
    """The bundled wave by its formula, by Newton's steps to the foot of each point."""
    k, a = 2.0 * np.pi / bundled.WAVE_LENGTH, bundled.WAVE_AMPLITUDE
    x = points[:, 0].copy()
    for _ in range(20):
        height, slope = bundled.WAVE_SKIRT + a * np.cos(k * x), -a * k * np.sin(k * x)
        error = (x - points[:, 0]) + (height - points[:, 2]) * slope
        x -= error / (1.0 + slope**2)
    normal = np.column_stack((-slope, 0.0 * x, np.ones(len(x))))
    foot = np.column_stack((x, points[:, 1], height))
    return np.linalg.norm(points - foot, axis=1), normal / np.linalg.norm(normal, axis=1, keepdims=True)


def on_triangles(corners: Array) -> Exact:
    """Sound triangles, each point's distance by the nearest of many samples; its normal is that of the triangle."""
    vertices, faces = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
    nearest = Nearest(vertices, faces, 0.3e-3)
    normals = face_vectors(vertices, faces)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)

    def exact(points: Array) -> tuple[Array, Array]:
        sample = nearest.sample(points)
        return nearest.distance(points, sample), normals[nearest.owner[sample]]

    return exact


def bases() -> dict[str, tuple[Array, Exact]]:
    """Sound triangles [m], centred in plan and on z = 0, and what is true of them."""
    mould = Mould.load(bundled.FREE_FORM)
    corners = mould.vertices[mould.faces]
    return {
        "dome": (bundled.dome(), on_dome),
        "wave": (bundled.wave(), on_wave),
        bundled.FREE_FORM: (corners, on_triangles(corners)),
    }


def planned(path: Path) -> tuple[Mould, list[Stroke]]:
    """The mould of a file, and a raster on it."""
    mould = Mould.load(str(path))
    grid = DistanceGrid.of(mould)
    return mould, raster(mould, grid, tip_radius=TIP, step=STEP, feed=FEED, force=FORCE, margin=MARGIN)


def judged(defect: Defect, corners: Array, exact: Exact, folder: Path) -> dict[str, Any]:
    """Spoil, write, load, plan, and compare with the truth."""
    spoilt = defect.spoil(corners, np.random.default_rng(5))
    path = folder / f"part{defect.ending}"
    path.write_bytes(defect.form(spoilt))
    start = time.process_time()
    result: dict[str, Any] = {"defect": defect.name}
    try:
        mould, strokes = planned(path)
    except BurnishError as error:
        reason = str(error).replace(str(path), "part")
        expected = defect.refused is not None and defect.refused in reason and isinstance(error, MouldError)
        return result | {
            "end": "refused", "said": reason, "met": expected,
            "seconds": time.process_time() - start,
        }  # fmt: skip
    points = np.concatenate([stroke.points for stroke in strokes])
    normals = np.concatenate([stroke.normals for stroke in strokes])
    # A mould is centred; a box beside the part has moved it.
    finite = spoilt[np.isfinite(spoilt).all(axis=(1, 2))]
    centre = (finite.min(axis=(0, 1)) + finite.max(axis=(0, 1))) / 2.0
    points = points + [*centre[:2], finite[:, :, 2].min()]
    off, true = exact(points)
    added = spoilt[len(corners) :] if len(spoilt) > len(corners) and "second shell" in defect.name else spoilt[:0]
    if len(added):
        other, facing = on_triangles(added[:, ::-1] if "inside out" in defect.name else added)(points)
        true = np.where((other < off)[:, None], facing, true)
        off = np.minimum(off, other)
    turned = np.rad2deg(np.arccos(np.clip(np.einsum("ij,ij->i", normals, true), -1.0, 1.0)))
    said = "; ".join(mould.warnings)
    good = off.max() <= 1e-3 * OFF_MM and turned.max() <= TURNED_DEG
    return result | {
        "end": "planned", "said": said, "off_mm": 1e3 * float(off.max()), "turned_deg": float(turned.max()),
        "length_m": float(sum(stroke.length for stroke in strokes)), "points": len(points),
        "met": bool(good and defect.refused is None and (defect.said or "") in said),
        "seconds": time.process_time() - start,
    }  # fmt: skip


def damaged(names: list[str]) -> Iterator[dict[str, Any]]:
    """All defects on these moulds, one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        for name, (corners, exact) in bases().items():
            if name in names:
                for defect in DEFECTS:
                    yield {"mould": name} | judged(defect, corners, exact, Path(folder))


def fine_wave(path: Path, faces: int) -> None:
    """The wave in about so many triangles, as a binary STL in mm."""
    across = int(np.sqrt(faces / 2.0 / 1.5))
    x, y = np.linspace(-0.06, 0.06, int(1.5 * across) + 1), np.linspace(-0.04, 0.04, across + 1)
    path.write_bytes(stl(1e3 * bundled.block(x, y, bundled.wave_height)))


CHILD = """
import json, resource, sys, time
from pathlib import Path
from finishing_meshes import planned
start, wall = time.process_time(), time.perf_counter()
mould, strokes = planned(Path(sys.argv[1]))
print(json.dumps({"faces": len(mould.faces), "seconds": time.process_time() - start,
    "wall": time.perf_counter() - wall, "MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
"""


def timed(sizes: tuple[int, ...]) -> list[dict[str, float]]:
    """Processor time, wall time and memory of load, grid and raster, each in a process of its own; least of two."""
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for size in sizes:
            path = Path(folder) / "wave.stl"
            fine_wave(path, size)
            tries = [
                json.loads(
                    subprocess.run(
                        [sys.executable, "-c", CHILD, str(path)], cwd=Path(__file__).parent, capture_output=True,
                        text=True, check=True,
                    ).stdout
                )
                for _ in range(2)
            ]  # fmt: skip
            results.append(min(tries, key=lambda found: found["seconds"]))
    return results


def exponent(results: list[dict[str, float]]) -> float:
    """p of time = c nᵖ by least squares over all sizes but the smallest; n log n has 1.08 from 30,000 to a million."""
    faces = np.array([found["faces"] for found in results])[1:]
    seconds = np.array([found["seconds"] for found in results])[1:]
    return float(np.polyfit(np.log(faces), np.log(seconds), 1)[0])


def rows(short: bool) -> list[dict[str, Any]]:
    """Found against asked for; ``short`` takes the dome alone, and no mesh above 100,000 triangles."""
    logging.getLogger("burnish").setLevel(logging.ERROR)
    found = list(damaged(["dome"] if short else ["dome", "wave", bundled.FREE_FORM]))
    times = timed(SIZES[:3] if short else SIZES)
    mould = Mould.load(bundled.FREE_FORM)
    start = time.process_time()
    raster(mould, DistanceGrid.of(mould), tip_radius=TIP, step=STEP, feed=FEED, force=FORCE, margin=MARGIN)
    spent = time.process_time() - start
    good = [case for case in found if case["end"] == "planned"]
    off, turned = max(case["off_mm"] for case in good), max(case["turned_deg"] for case in good)
    wrong = [f"{case['mould']}: {case['defect']}" for case in found if not case["met"]]
    largest, power = times[-1], exponent(times)
    return [
        row("damaged meshes planned or refused as they must", len(found) - len(wrong), len(found), "meshes",
            not wrong, "; ".join(wrong) or f"{len(good)} planned, {len(found) - len(good)} refused"),
        row("waypoint farthest off the true surface", off, OFF_MM, "mm", off <= OFF_MM, "of all damaged meshes"),
        row("normal farthest from the true one", turned, TURNED_DEG, "deg", turned <= TURNED_DEG, "outward: below 90"),
        row("plan of the bundled mould", spent, 10.0, "s", spent <= 10.0, "grid and raster, processor time"),
        row(f"plan of {largest['faces']:,} triangles", largest["wall"], 60.0, "s", largest["wall"] <= 60.0,
            f"load, grid and raster on the wall; {largest['seconds']:.1f} s of processor time"),
        row(f"memory of {largest['faces']:,} triangles", largest["MiB"] / 1024, 4.0, "GiB",
            largest["MiB"] <= 4096, "largest resident size"),
        row("growth with triangles, exponent", power, 1.08, "", power <= 1.08,
            "; ".join(f"{one['faces']:,}: {one['seconds']:.1f} s" for one in times)),
    ]  # fmt: skip


def row(name: str, found: float, goal: float, unit: str, met: bool, note: str) -> dict[str, Any]:
    """A line of the table."""
    return {"name": name, "found": found, "goal": goal, "unit": unit, "met": bool(met), "note": note}


def main() -> int:
    """Print the tables; exit status 1 if a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--short", action="store_true", help="the dome alone, and no mesh above 100,000 triangles")
    parser.add_argument(
        "--cases", action="store_true", help="every damaged mesh in a line of its own, and nothing else"
    )
    parser.add_argument("--out", type=Path, metavar="FILE.json", help="file for the result")
    options = parser.parse_args()
    if options.cases:
        logging.getLogger("burnish").setLevel(logging.ERROR)
        met = True
        for case in damaged(["dome"] if options.short else ["dome", "wave", bundled.FREE_FORM]):
            met = met and case["met"]
            numbers = (
                f"{case['off_mm']:.4f} mm {case['turned_deg']:.2f}° {case['length_m']:.2f} m"
                if "off_mm" in case
                else ""
            )
            sys.stdout.write(
                f"{'ok ' if case['met'] else 'NOT'} {case['mould']:6} {case['defect']:32} {case['end']} {numbers} "
                f"{case['seconds']:.1f} s  {case['said']}\n"
            )
            sys.stdout.flush()
        return int(not met)
    found = rows(options.short)
    cells = [
        [
            one["name"],
            f"{one['found']:.4g}",
            f"{one['goal']:.4g}",
            one["unit"],
            "yes" if one["met"] else "NO",
            one["note"],
        ]
        for one in found
    ]
    sys.stdout.write(text_table(("", "found", "goal", "unit", "met", "note"), cells) + "\n")
    if options.out is not None:
        write_json(options.out, {"machine": machine(), "rows": found})
    return int(not all(one["met"] for one in found))


if __name__ == "__main__":
    sys.exit(main())
