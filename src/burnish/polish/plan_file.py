"""A plan in a file: the strokes, the mould that they were made for, and the recipe.

A file may be anything: it becomes a plan, or one sentence that says why not.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from burnish.errors import InputError, PlanError
from burnish.paths.stroke import Stroke, as_plan, from_plan
from burnish.polish.recipe import Recipe
from burnish.polish.recipe_file import as_tables, from_tables
from burnish.surface import Mould

MAX_BYTES = 64 * 2**20
"""Largest file that is read [B]: about 400,000 points, 200 m of path at half a millimetre."""
_HEX = frozenset("0123456789abcdef")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a file holds."""

    strokes: list[Stroke]
    """The strokes, mould frame, at least one."""
    made_for: str | None
    """Fingerprint of the mould that they were made for; None where the file names none."""
    recipe: Recipe | None
    """The recipe that they were made with; None where the file holds none."""


def write_plan(path: Path, strokes: Sequence[Stroke], mould: Mould, recipe: Recipe) -> None:
    """Write a plan, whole or not at all: mould frame, m, m/s, N.

    Raises:
        InputError: it cannot be written.
    """
    plan = as_plan(strokes) | {"mould": {"name": mould.name, "sha256": mould.sha256}, "recipe": as_tables(recipe)}
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(json.dumps(plan, allow_nan=False), encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror}); choose another file") from None


def read_plan(path: Path) -> list[Stroke]:
    """The strokes of a file that ``burnish plan`` wrote: mould frame, m, m/s, N.

    Raises:
        PlanError: it cannot be read, is too large, or is no plan of finite numbers.
    """
    return load_plan(path).strokes


def load_plan(path: Path) -> Plan:
    """The strokes of a file with what it says of their mould and recipe.

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
        strokes = from_plan(plan)
        recipe = from_tables(plan["recipe"]) if "recipe" in plan else None
        return Plan(strokes=strokes, made_for=_made_for(plan), recipe=recipe)
    except InputError as error:
        raise PlanError(f"{path}: {error}") from None


def _made_for(plan: Mapping[str, Any]) -> str | None:
    """The fingerprint that a plan names."""
    if "mould" not in plan:
        return None
    named = plan["mould"]
    sha = named.get("sha256") if isinstance(named, dict) else None
    if not isinstance(sha, str) or len(sha) != 64 or not _HEX.issuperset(sha):
        raise PlanError('its mould has no fingerprint; expected "mould": {"name": …, "sha256": 64 digits}')
    return sha


def _refuse(name: str) -> NoReturn:
    """Python's reader takes NaN and Infinity, which JSON does not have."""
    raise ValueError(f"the number {name}")
