"""Rows of the library in words: one line in a list, a table in detail."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime, timezone
from typing import Any

from burnish.gui import words
from burnish.library import DemonstrationRow, Library, MouldRow, PlanRow, RecipeRow, Row, RunRow

BIN = "bin"
KINDS: Mapping[str, Callable[..., list[Any]]] = {
    "runs": Library.runs,
    "moulds": Library.moulds,
    "recipes": Library.recipes,
    "demonstrations": Library.demonstrations,
    "plans": Library.plans,
}
"""What the library lists, and by which of its functions."""
LISTED = 50
"""Rows of a list at most; a search finds the others."""
ANY_TAG = "any tag"


def found(library: Library, kind: str, search: str, tag: str) -> list[Row]:
    """The rows of a list, the newest first."""
    if kind == BIN:
        return list(library.binned(limit=LISTED))
    return list(KINDS[kind](library, search, tag=None if tag == ANY_TAG else tag, limit=LISTED))


def labels(rows: list[Row]) -> dict[str, Row]:
    """Each row under a line of its own."""
    named: dict[str, Row] = {}
    for row in rows:
        label = line(row)
        named[label if label not in named else f"{label} ({row.id[:6]})"] = row
    return named


def line(row: Row) -> str:
    """A row in one line."""
    if isinstance(row, RunRow):
        # A run is called after its day until somebody gives it a name.
        return " · ".join([row.mould or row.verb, row.ended, row.name])
    return " · ".join([row.name, when(row.created)])


def when(moment: datetime) -> str:
    """Date and time here."""
    return f"{moment.replace(tzinfo=moment.tzinfo or timezone.utc).astimezone():%d %b %Y, %H:%M}"


def details(row: Row) -> list[tuple[str, str]]:
    """A row in words and figures."""
    return [("kind", kind(row)), *_own(row), ("entered", when(row.created)), ("tags", ", ".join(row.tags) or "–")]


def compared(left: RunRow, right: RunRow) -> list[tuple[str, str, str]]:
    """Two runs side by side: what, the one, the other."""
    pairs = [(what, one, other) for (what, one), (_, other) in zip(_done(left), _done(right), strict=True)]
    return [*pairs, *words.compared(left.metrics, right.metrics)]


def kind(row: Row) -> str:
    """What a row is."""
    return type(row).__name__.removesuffix("Row").lower()


def _done(row: RunRow) -> list[tuple[str, str]]:
    """What a run was, without its figures."""
    arm = f"{row.arm}, simulated" if row.arm else "–"
    return [("verb", row.verb), ("mould", row.mould or "–"), ("arm", arm), ("ended", row.outcome)]


def _own(row: Row) -> list[tuple[str, str]]:
    if isinstance(row, RunRow):
        return [*_done(row), *words.figures(row.metrics)]
    if isinstance(row, MouldRow):
        unit = "found from its size" if row.unit == "auto" else row.unit
        return [("size", words.size_in_mm(row.size)), ("triangles", str(row.triangles)), ("unit of the file", unit)]
    if isinstance(row, RecipeRow):
        return [
            ("force", words.number(row.force, "N")),
            ("feed", words.number(1e3 * row.feed, "mm/s")),
            ("passes", f"{row.passes} ({row.patterns})" if row.patterns else str(row.passes)),
            ("abrasive", row.grit or "–"),
        ]
    if isinstance(row, DemonstrationRow):
        return [
            ("mould", row.mould),
            ("shown with", row.device),
            ("time", words.duration(row.duration)),
            ("in contact", f"{100.0 * row.contact:.0f} %"),
            ("largest force", words.number(row.force_most, "N")),
        ]
    if isinstance(row, PlanRow):
        return [
            ("strokes", str(row.strokes)),
            ("path", words.number(row.length, "m", 2)),
            ("time on the surface", words.duration(row.duration)),
        ]
    return []
