"""A recipe as a file that a person can read and change: TOML with the unit and the range beside every number.

What is not in the file is as in `Recipe`. All numbers are in SI, angles in radians, so that they come back exactly.
"""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from burnish.errors import InputError
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Contour, CrossHatch, Geodesic, Pattern, Polyline, Raster, Spiral
from burnish.paths.tilt import Tilt
from burnish.polish.ranges import Range
from burnish.polish.recipe import ANGLE, BOUNDS, FEED, FORCE, LEAN, PRESTONS, SPINDLE, STEP, TOOL, Bounds, Pass, Recipe
from burnish.polish.wanted import EVEN, ROUGHNESS, Even, Smoothing

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PATTERNS: Mapping[str, type[Pattern]] = {
    "raster": Raster,
    "cross_hatch": CrossHatch,
    "spiral": Spiral,
    "contour": Contour,
    "geodesic": Geodesic,
    "polyline": Polyline,
}
"""What a pattern is called in a file."""
MAX_BYTES = 2**20
"""Largest file that is read [B]."""
MOST_POINTS = 10_000
"""Points of a drawn path."""
FARTHEST = 1.0
"""Largest coordinate of a drawn path [m]."""
HEAD = "# Recipe of a finishing job. SI units; what is left out has its default.\n"
_PASS = {"force": FORCE, "feed": FEED, "step": STEP}
_HALF_TURN = Range(unit="rad", low=-float(np.pi), high=float(np.pi))
_TILT = {"tilt": ("angle", LEAN), "tilt_heading": ("heading", _HALF_TURN)}
_NOTES = {"tilt_heading": ", where the body leans to: from the mould's x to its y, wherever the path goes"}
_TOP = {"force": FORCE, "feed": FEED, "preston": PRESTONS}
_RPM = float(np.pi / 30.0)
"""A turn a minute [rad/s]."""
_SPINDLES = {
    "spindle_rad_s": (SPINDLE, 1.0),
    "spindle_rpm": (Range(unit="rpm", low=-28_000.0, high=28_000.0), _RPM),
}
"""Names of the spindle's speed in a file, of which it states one: what it may be, and its unit in rad/s."""
_WANTED: Mapping[str, tuple[type[Even] | type[Smoothing], Mapping[str, Range]]] = {
    "even": (Even, EVEN),
    "roughness": (Smoothing, ROUGHNESS),
}
"""Tables that a recipe may leave out as a whole."""


def read_recipe(path: Path) -> Recipe:
    """The recipe in a file, which may be anything.

    Raises:
        InputError: it cannot be read, is no TOML, has an unknown key, or a value that is out of range.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise InputError(f"{str(path)!r} cannot be read ({error}); expected a recipe in TOML") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{path} is larger than {MAX_BYTES // 2**20} MiB; expected a recipe")
    try:
        tables = tomllib.loads(data.decode())
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is no recipe ({str(error)[:200]}); expected TOML") from None
    try:
        return from_tables(tables)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_recipe(recipe: Recipe, path: Path) -> None:
    """Write a recipe, whole or not at all.

    Raises:
        InputError: it cannot be written.
    """
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(as_toml(recipe), encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror}); choose another file") from None


def as_toml(recipe: Recipe) -> str:
    """The text of a recipe file, a comment beside every number."""
    tables = as_tables(recipe)
    passes = tables.pop("passes", [])
    text = HEAD + "".join(_lines({k: v for k, v in tables.items() if not isinstance(v, dict)}, _TOP))
    own = {name: ranges for name, (_, ranges) in _WANTED.items() if name in tables}
    for name, ranges in {"tool": {**TOOL, "spindle_rad_s": SPINDLE}, "limits": BOUNDS, **own}.items():
        text += f"\n[{name}]\n" + "".join(_lines(tables[name], ranges))
    for one in passes:
        known = _PASS | {"angle": ANGLE} | {key: allowed for key, (_, allowed) in _TILT.items()}
        text += "\n[[passes]]\n" + "".join(_lines(one, known))
    return text


def as_tables(recipe: Recipe) -> dict[str, Any]:
    """A recipe in plain dictionaries, ready for TOML or JSON."""
    tables = {name: getattr(recipe, name) for name in ("grit", *_TOP)}
    tables["tool"] = {name: getattr(recipe.tool, name) for name in TOOL}
    if recipe.tool.spindle != 0.0:
        tables["tool"]["spindle_rad_s"] = recipe.tool.spindle
    tables["limits"] = {name: getattr(recipe.limits, name) for name in BOUNDS}
    for table, (_, ranges) in _WANTED.items():
        if (wanted := getattr(recipe, table)) is not None:
            tables[table] = {name: getattr(wanted, name) for name in ranges}
    if recipe.passes:
        tables["passes"] = [_pass_table(one) for one in recipe.passes]
    return tables


def from_tables(tables: Any) -> Recipe:
    """The recipe of what was read from a file, whatever it was.

    Raises:
        InputError: an unknown key, or a value that is out of range.
    """
    _check_keys("the recipe", tables, ("grit", *_TOP, "tool", "limits", *_WANTED, "passes"))
    given = _numbers("", tables, _TOP)
    if "grit" in tables:
        given["grit"] = tables["grit"]
    if "tool" in tables:
        _check_keys("tool", tables["tool"], (*TOOL, *_SPINDLES))
        given["tool"] = PolishingTool(**_numbers("tool: ", tables["tool"], TOOL), **_spindle(tables["tool"]))
    if "limits" in tables:
        _check_keys("limits", tables["limits"], BOUNDS)
        given["limits"] = Bounds(**_numbers("limits: ", tables["limits"], BOUNDS))
    for name, (kind, ranges) in _WANTED.items():
        if name in tables:
            given[name] = _wanted(name, tables[name], kind, ranges)
    passes = tables.get("passes", [])
    if not isinstance(passes, list):
        raise InputError("passes is no list; expected one table [[passes]] for each pass")
    given["passes"] = tuple(_pass(f"pass {number}", one) for number, one in enumerate(passes, 1))
    return Recipe(**given)


def _spindle(table: Mapping[str, Any]) -> dict[str, float]:
    """The spindle's speed, if the table states one [rad/s]."""
    stated = [name for name in _SPINDLES if name in table]
    if len(stated) > 1:
        raise InputError(f"tool: {' and '.join(stated)} both state the spindle's speed; expected one of them")
    for name in stated:
        allowed, unit = _SPINDLES[name]
        allowed.check(f"tool: {name}", table[name])
        return {"spindle": unit * float(table[name])}
    return {}


def _wanted(name: str, table: Any, kind: type[Even] | type[Smoothing], ranges: Mapping[str, Range]) -> Even | Smoothing:
    """A table that states what is wanted of the surface."""
    _check_keys(name, table, ranges)
    missing = [one.name for one in fields(kind) if one.default is MISSING and one.name not in table]
    if missing:
        raise InputError(f"{name} does not state {', '.join(missing)}; expected {missing[0]} = a number in m")
    return kind(**_numbers(f"{name}: ", table, ranges))


def _pass_table(one: Pass) -> dict[str, Any]:
    """A pass in plain values, without what it leaves to the recipe."""
    name = next(name for name, kind in PATTERNS.items() if type(one.pattern) is kind)
    table: dict[str, Any] = {"pattern": name}
    for key in _own_keys(name):
        value = getattr(one.pattern, key)
        table[key] = value.tolist() if isinstance(value, np.ndarray) else value
    table |= {key: getattr(one, key) for key in _PASS if getattr(one, key) is not None}
    if one.tilt != Tilt():
        table |= {key: getattr(one.tilt, own) for key, (own, _) in _TILT.items()}
    return table


def _pass(where: str, table: Any) -> Pass:
    """The pass of a table."""
    if not isinstance(table, dict) or not isinstance(table.get("pattern"), str):
        raise InputError(f"{where} names no pattern; expected pattern = one of {', '.join(PATTERNS)}")
    name = table["pattern"]
    if name not in PATTERNS:
        raise InputError(f"{where}: there is no pattern {name[:40]!r}{_nearest(name, PATTERNS)}")
    own = _own_keys(name)
    _check_keys(where, table, ("pattern", *own, *_PASS, *_TILT))
    values: dict[str, Any] = _numbers(f"{where}: ", table, {"angle": ANGLE})
    if "points" in own:
        values["points"] = _points(where, table.get("points"))
    tilt = _numbers(f"{where}: ", table, {key: allowed for key, (_, allowed) in _TILT.items()})
    return Pass(
        pattern=PATTERNS[name](**values),
        tilt=Tilt(**{_TILT[key][0]: value for key, value in tilt.items()}),
        **_numbers(f"{where}: ", table, _PASS),
    )


def _own_keys(name: str) -> tuple[str, ...]:
    """The fields of a pattern."""
    return tuple(one.name for one in fields(PATTERNS[name]))  # type: ignore[arg-type]


def _points(where: str, rows: Any) -> np.ndarray[Any, Any]:
    """The corners of a drawn path."""
    good = isinstance(rows, list) and 2 <= len(rows) <= MOST_POINTS
    for row in rows if good else []:
        good = good and isinstance(row, list) and len(row) == len(rows[0]) and len(row) in (2, 3)
        for value in row if good else []:
            Range(unit="m", low=-FARTHEST, high=FARTHEST).check(f"{where}: a coordinate", value)
    if not good:
        raise InputError(
            f"{where}: points are no path; expected 2 to {MOST_POINTS} rows [x, y] or [x, y, z] in m, as in "
            "points = [[0.0, 0.0], [0.05, 0.0]]"
        )
    return np.array(rows, dtype=np.float64)


def _numbers(where: str, table: Mapping[str, Any], ranges: Mapping[str, Range]) -> dict[str, Any]:
    """The numbers of a table that it gives, each within its range."""
    found = {}
    for name, allowed in ranges.items():
        if name in table:
            allowed.check(where + name, table[name])
            found[name] = float(table[name])
    return found


def _check_keys(where: str, table: Any, known: Collection[str]) -> None:
    """Refuse a key that nobody knows, with the nearest one that somebody does."""
    if not isinstance(table, dict):
        raise InputError(f"{where} is no table; expected keys with values: {', '.join(known)}")
    for key in table:
        if key not in known:
            raise InputError(f"{where} has no key {str(key)[:40]!r}{_nearest(str(key), known)}")


def _nearest(word: str, known: Collection[str]) -> str:
    """What was probably meant, for a message."""
    near = difflib.get_close_matches(word[:40], known, n=1)
    return f"; did you mean {near[0]!r}?" if near else f"; expected one of {', '.join(known)}"


def _lines(table: Mapping[str, Any], ranges: Mapping[str, Range]) -> Iterator[str]:
    """The lines of a table, with units."""
    for name, value in table.items():
        line = tomli_w.dumps({name: value}).rstrip("\n")
        yield f"{line}  # {_comment(ranges[name], value)}{_NOTES.get(name, '')}\n" if name in ranges else f"{line}\n"


def _comment(allowed: Range, value: float) -> str:
    """Unit and range of a number; radians in degrees, and radians a second in turns a minute too."""
    other = {"rad": f", {np.rad2deg(value):.4g}°", "rad/s": f", {value / _RPM:.4g} rpm"}.get(allowed.unit, "")
    unit = f"[{allowed.unit}]" if allowed.unit else "[-]"
    return f"{unit} {allowed.low:.4g} to {allowed.high:.4g}{other}"
