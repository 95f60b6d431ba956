"""What the library holds, a frozen row each: moulds, tools, recipes, demonstrations, plans and runs."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import ClassVar

from burnish.errors import InputError

Scalar = float | int | str | bool
"""What stands in ``metrics.json``."""
LONGEST_NAME, LONGEST_NOTES, LONGEST_TAG = 200, 20_000, 50
"""Characters."""
DIGITS = re.compile(r"[0-9a-f]{64}")
ENDING = re.compile(r"\.[a-z0-9]{1,8}")
ID = re.compile(r"[0-9a-f]{32}")
ROLE = re.compile(r"[a-z0-9-]{1,40}")


@dataclass(frozen=True, kw_only=True)
class Stored:
    """A file of the library, named by its content."""

    role: str
    """What it is to its row: ``mesh``, ``recording``, ``report`` …"""
    sha256: str
    """Of its bytes."""
    size: int
    """[B]"""
    ending: str
    """With the point, ``.stl``."""

    def __post_init__(self) -> None:
        good = DIGITS.fullmatch(self.sha256) and ENDING.fullmatch(self.ending) and ROLE.fullmatch(self.role)
        if not good or self.size < 0:
            raise InputError(
                f"a file of the library is named {self.sha256[:70]!r} {self.ending[:10]!r}; expected 64 digits and an "
                "ending such as '.stl'"
            )

    @property
    def path(self) -> str:
        """Where it lies below the library's root."""
        return f"files/{self.sha256[:2]}/{self.sha256}{self.ending}"


@dataclass(frozen=True, kw_only=True)
class Row:
    """What all kinds have in common."""

    KIND: ClassVar[str]
    """What it is, in a word."""

    id: str
    """Follows from the content: what is entered twice is there once."""
    name: str
    """For people; need not be unique."""
    created: datetime
    """When it was entered first, UTC."""
    files: tuple[Stored, ...]
    """The main one first."""
    tags: tuple[str, ...] = ()
    """Words to find it by, in order."""
    notes: str = ""
    """Whatever somebody wrote."""
    binned: datetime | None = None
    """When it was put into the bin, UTC; None where it is in use."""

    def __post_init__(self) -> None:
        if not ID.fullmatch(self.id):
            raise InputError(f"a row of the library has the id {self.id[:40]!r}; expected 32 digits")
        object.__setattr__(self, "name", one_line(self.name, LONGEST_NAME) or "without a name")
        object.__setattr__(self, "tags", tuple(sorted(set(self.tags))))

    @property
    def words(self) -> str:
        """What a search looks through, in small letters."""
        return " ".join((self.name, *self.tags, self.notes)).casefold()


@dataclass(frozen=True, kw_only=True)
class MouldRow(Row):
    """A part to be worked."""

    KIND = "mould"

    geometry: str
    """Fingerprint of the geometry, `Mould.sha256`."""
    unit: str
    """What `Mould.load` has to be told of the file: ``mm``, ``m``, ``inch``, or ``auto``."""
    size: tuple[float, ...]
    """Sides of the bounding box, mould frame [m], (3,)."""
    triangles: int
    """How many."""
    warnings: tuple[str, ...] = ()
    """What was assumed and mended."""


@dataclass(frozen=True, kw_only=True)
class ToolRow(Row):
    """A tool."""

    KIND = "tool"

    fingerprint: str
    """Of all its figures."""
    tip_radius: float
    """[m]"""
    length: float
    """Sensor to apex [m]."""
    stiffness: float
    """Of the tip's spring [N/m]."""
    modulus: float
    """Effective contact modulus [Pa]."""
    friction: float
    """Coulomb friction of the tip on the part."""


@dataclass(frozen=True, kw_only=True)
class RecipeRow(Row):
    """What is to be done on a mould."""

    KIND = "recipe"

    force: float
    """[N]"""
    feed: float
    """[m/s]"""
    passes: int
    """How many, at least 1."""
    patterns: str
    """Names of their patterns."""
    grit: str
    """The abrasive, or nothing."""
    tool: str
    """Fingerprint of its tool."""

    @property
    def words(self) -> str:
        """Its patterns and abrasive too."""
        return f"{super().words} {self.patterns} {self.grit}".casefold()


@dataclass(frozen=True, kw_only=True)
class DemonstrationRow(Row):
    """What an operator showed."""

    KIND = "demonstration"

    mould: str
    """Name of the mould."""
    mould_sha256: str
    """Fingerprint of its geometry."""
    arm: str
    """Name of the arm."""
    device: str
    """What was commanded with."""
    duration: float
    """[s]"""
    cycles: int
    """Of the control."""
    contact: float
    """Share of the time in contact."""
    force_most: float
    """Largest force in contact [N]."""

    @property
    def words(self) -> str:
        """Its mould and device too."""
        return f"{super().words} {self.mould} {self.arm} {self.device}".casefold()


@dataclass(frozen=True, kw_only=True)
class PlanRow(Row):
    """A checked tool path."""

    KIND = "plan"

    mould_sha256: str
    """Fingerprint of the mould that it was made for; nothing where it names none."""
    strokes: int
    """How many."""
    length: float
    """Of the path [m]."""
    duration: float
    """At the planned feed [s]."""


@dataclass(frozen=True, kw_only=True)
class RunRow(Row):
    """A job, and what came of it."""

    KIND = "run"

    verb: str
    """``polish``, ``teach``, ``replay`` or ``campaign``."""
    mould: str
    """Name of the mould, or nothing."""
    mould_sha256: str
    """Fingerprint of its geometry, or nothing."""
    arm: str
    """Name of the arm, or nothing."""
    sensor: str
    """What it felt with, or nothing."""
    ended: str
    """``done``, ``stopped``, ``interrupted``, ``paused``, ``cancelled``; ``lost`` where nobody could say."""
    outcome: str
    """How it ended, in words."""
    duration: float
    """Of the arm's clock [s]."""
    folder: str
    """Where it was made; nothing is ever read from there but by `add_run`."""
    metrics: Mapping[str, Scalar] = field(default_factory=dict)
    """Its figures, as in ``metrics.json``."""

    @property
    def words(self) -> str:
        """Its verb, mould, arm and outcome too."""
        return f"{super().words} {self.verb} {self.mould} {self.arm} {self.sensor} {self.outcome}".casefold()


KINDS: Mapping[str, type[Row]] = {
    kind.KIND: kind for kind in (MouldRow, ToolRow, RecipeRow, DemonstrationRow, PlanRow, RunRow)
}
"""Word to row."""


def identity(kind: type[Row], *parts: str) -> str:
    """The id of a row: 32 digits that follow from what it is."""
    return hashlib.sha256("\0".join((kind.KIND, *parts)).encode()).hexdigest()[:32]


def one_line(text: str, most: int) -> str:
    """A text from anywhere as one line that can be shown and stored: no control characters, not too long."""
    return " ".join(_printable(text).split())[:most].strip()


def several_lines(text: str, most: int) -> str:
    """The same where lines are kept."""
    return "\n".join(_printable(line) for line in text.splitlines())[:most].strip()


def _printable(text: str) -> str:
    """Without control characters, unpaired surrogates and what turns the direction of writing."""
    return "".join(" " if c in "\t\n" else c for c in text if c in "\t\n" or unicodedata.category(c)[0] != "C")
