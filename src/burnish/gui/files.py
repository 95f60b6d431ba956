"""Which files of the library the workshop serves beside itself, each by what it is and its entry's id."""

from __future__ import annotations

from pathlib import Path

from burnish.errors import BurnishError
from burnish.gui.pages import Page, Pages
from burnish.library import DemonstrationRow, Library, MouldRow, PlanRow, RecipeRow, Row, RunRow

SHOWN = {"report": "report.html", "part": "part.html"}
"""What is shown, and what it is called in the folder of a run."""
STORED = ("recording", "mesh", "recipe", "plan")
"""What a browser stores."""
KINDS: tuple[type[Row], ...] = (RunRow, MouldRow, RecipeRow, DemonstrationRow, PlanRow)


def offer(pages: Pages, library: Library, runs: Path) -> None:
    """Serve the library's files.

    Args:
        pages: where.
        library: what.
        runs: folder of the jobs under way; a folder of it is found by its name.
    """
    for role, file in SHOWN.items():
        pages.add(role, lambda name, role=role, file=file: _shown(library, runs, name, role, file))  # type: ignore[misc]
    for role in STORED:
        pages.add(role, lambda name, role=role: _stored(library, name, role))  # type: ignore[misc]
    pages.add("thumb", lambda name: _thumb(library, name))


def row_of(library: Library, name: str) -> Row | None:
    """The entry of an id, of whatever kind."""
    for kind in KINDS:
        try:
            return library.get(kind, name)
        except BurnishError:
            continue
    return None


def _shown(library: Library, runs: Path, name: str, role: str, file: str) -> Page | None:
    if (runs / name / file).is_file():
        return Page(path=runs / name / file)
    row = row_of(library, name)
    return None if row is None else _page(library, row, role, None)


def _stored(library: Library, name: str, role: str) -> Page | None:
    row = row_of(library, name)
    if row is None:
        return None
    ending = next((one.ending for one in row.files if one.role == role), "")
    return _page(library, row, role, f"{row.name}{ending}")


def _thumb(library: Library, name: str) -> Page | None:
    row = row_of(library, name)
    picture = None if row is None else library.thumbnail(row)
    return None if picture is None else Page(path=picture)


def _page(library: Library, row: Row, role: str, save_as: str | None) -> Page | None:
    try:
        return Page(path=library.file(row, role), save_as=save_as)
    except BurnishError:
        return None
