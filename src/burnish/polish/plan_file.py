"""Reading a plan from a file that may be anything: it becomes strokes, or one sentence that says why not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NoReturn

from burnish.errors import PlanError
from burnish.polish.stroke import Stroke, from_plan

MAX_BYTES = 16 * 2**20
"""Largest file that is read [B]: about 100,000 points, 50 m of path at half a millimetre."""


def read_plan(path: Path) -> list[Stroke]:
    """The strokes of a file that ``burnish plan`` wrote: mould frame, m, m/s, N.

    Raises:
        PlanError: it cannot be read, is too large, or is no plan of finite numbers.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise PlanError(f"{str(path)!r} cannot be read ({error}); expected a plan in JSON") from None
    if len(data) > MAX_BYTES:
        raise PlanError(f"{path} is larger than {MAX_BYTES // 2**20} MiB; expected a plan: split the job")
    try:
        plan = json.loads(data, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise PlanError(f"{path} is no plan ({str(error)[:200]}); expected JSON as 'burnish plan' writes it") from None
    try:
        return from_plan(plan)
    except PlanError as error:
        raise PlanError(f"{path}: {error}") from None


def _refuse(name: str) -> NoReturn:
    """Python's reader takes NaN and Infinity, which JSON does not have."""
    raise ValueError(f"the number {name}")
