"""What the benchmarks share: plain tables, results with the versions that made them, and pieces of a tool path."""

from __future__ import annotations

import itertools
import json
import os
import platform
from collections.abc import Mapping, Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from burnish.paths.stroke import Stroke

PACKAGES = ("burnish", "mujoco", "pin", "numpy", "scipy")
SHORTEST = 40
"""Points of the shortest line that is used: 20 mm, a second of a slow feed."""


def machine() -> dict[str, Any]:
    """Cores, date and versions; nothing that names the machine."""
    return {
        "date": date.today().isoformat(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "architecture": platform.machine(),
        "python": platform.python_version(),
    } | {name: version(name) for name in PACKAGES}


def text_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns of equal width: the first to the left, the others to the right."""
    widths = [max(len(line[i]) for line in (head, *rows)) for i in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        return "  ".join(
            c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))
        ).rstrip()

    return "\n".join([line(head), line(["-" * w for w in widths]), *(line(row) for row in rows)])


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """The same as Markdown."""
    rule = ["---"] + ["---:"] * (len(head) - 1)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, rule, *rows))


def write_json(path: Path, result: Mapping[str, Any]) -> None:
    """Write a result, whole or not at all."""
    write_text(path, json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a text beside ``path`` and move it there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.draft")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)


def comma_numbers(text: str) -> list[int]:
    """``1,2,5`` or ``1-5`` as whole numbers, for argparse."""
    numbers: list[int] = []
    for piece in text.split(","):
        first, _, last = piece.partition("-")
        numbers += range(int(first), int(last or first) + 1)
    return numbers


def pieces_of(strokes: Sequence[Stroke], count: int) -> list[Stroke]:
    """``count`` pieces spread evenly over a path, each two neighbouring lines and the turn between them."""
    pairs = []
    for stroke in strokes:
        pairs += [
            Stroke(**{k: getattr(stroke, k)[first : last + 1] for k in ("points", "normals", "feed", "force")})
            for (first, _), (_, last) in itertools.pairwise(line_ends(stroke))
        ]
    # Half a share from each border, so that one piece alone is the middle one.
    chosen = ((np.arange(count) + 0.5) * len(pairs) / count).astype(int)
    return [pairs[i] for i in np.unique(chosen)]


def line_ends(stroke: Stroke) -> list[tuple[int, int]]:
    """First and last point of each straight line of a stroke, in order."""
    step = np.gradient(stroke.points[:, :2], axis=0)
    # Where the path runs across the lines rather than along them, it turns.
    side = np.where(np.abs(step[:, 0]) > 0.9 * np.linalg.norm(step, axis=1), np.sign(step[:, 0]), 0.0)
    pieces = np.split(np.arange(len(side)), np.flatnonzero(np.diff(side)) + 1)
    return [(int(piece[0]), int(piece[-1])) for piece in pieces if side[piece[0]] and len(piece) >= SHORTEST]


def line_distance(strokes: Sequence[Stroke]) -> float:
    """Mean distance in plan of neighbouring lines within a stroke [m]."""
    between = [
        abs(float(stroke.points[b, 1] - stroke.points[a, 1]))
        for stroke in strokes
        for (a, _), (b, _) in itertools.pairwise(line_ends(stroke))
    ]
    return float(np.mean(between))
