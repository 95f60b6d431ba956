"""The part that is mounted: where its file lies, and what of it is drawn."""

from __future__ import annotations

from dataclasses import dataclass

from burnish.gui.paint import Canvas
from burnish.gui.words import size_in_mm
from burnish.library import Library, MouldRow
from burnish.surface import Mould, bundled

WORKSHOP = "work"
"""Folder below the library's root for what is under way."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A mould that can be worked."""

    name: str
    """As the page calls it."""
    source: str
    """What the command line calls it: a bundled name, or the path of a file."""
    unit: str
    """Unit of that file, or ``auto``."""
    mould: Mould
    """The mould."""
    canvas: Canvas
    """What of it is painted."""

    @property
    def says(self) -> str:
        """Size and what was mended, in words."""
        sides = (self.mould.vertices.max(axis=0) - self.mould.vertices.min(axis=0)).tolist()
        return ". ".join([f"{size_in_mm(tuple(sides))}, {len(self.mould.faces)} triangles", *self.mould.warnings])

    @classmethod
    def bundled(cls, name: str) -> Part:
        """One that comes with burnish.

        Raises:
            MouldError: there is no such mould.
        """
        mould = Mould.load(name)
        return cls(name=name, source=name, unit="auto", mould=mould, canvas=Canvas.of(mould))

    @classmethod
    def of_row(cls, library: Library, row: MouldRow) -> Part:
        """One of the library.

        Raises:
            InputError: its file is gone, or is none.
        """
        folder = library.root / WORKSHOP / "moulds" / row.id
        folder.mkdir(parents=True, exist_ok=True)
        path = library.export(row, folder)
        mould = Mould.load(str(path), None if row.unit == "auto" else row.unit)
        return cls(name=row.name, source=str(path), unit=row.unit, mould=mould, canvas=Canvas.of(mould))


def named(library: Library, choice: str) -> Part:
    """The part of a choice that `choices` offers.

    Raises:
        InputError: it is gone.
    """
    if choice in bundled.NAMES:
        return Part.bundled(choice)
    return Part.of_row(library, library.get(MouldRow, choice.rsplit("#", 1)[-1]))


def choices(library: Library) -> dict[str, str]:
    """What can be mounted, as the page calls it, to what `named` takes: the library's first, the newest on top."""
    found: dict[str, str] = {}
    for row in library.moulds(limit=200):
        shown = row.name if row.name not in found and row.name not in bundled.NAMES else f"{row.name} ({row.id[:6]})"
        found[shown] = f"#{row.id}"
    return found | {name: name for name in bundled.NAMES}
