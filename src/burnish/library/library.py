"""The library: a folder of files, and a database in which they are found."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path, PurePath

from sqlalchemy import ColumnElement, Select, func, select

from burnish.errors import InputError
from burnish.library import archive, audit
from burnish.library.changes import locked, make, prepared
from burnish.library.readers import (
    AUTO,
    MESHES,
    now,
    read_demonstration,
    read_mould,
    read_plan_row,
    read_recipe_row,
    read_tool,
)
from burnish.library.rows import (
    LONGEST_NAME,
    LONGEST_NOTES,
    LONGEST_TAG,
    DemonstrationRow,
    MouldRow,
    PlanRow,
    RecipeRow,
    Row,
    RunRow,
    ToolRow,
    one_line,
    several_lines,
)
from burnish.library.run_reader import read_run
from burnish.library.shelf import R, Shelf
from burnish.library.storage import Source, disk
from burnish.library.tables import TABLES, Entry, Run, Tag
from burnish.model.tool import PolishingTool

AT_ONCE = 200
"""Rows of the bin that are removed in one change."""


class Library(Shelf):
    """A library; safe to be used by several threads and processes at the same time.

    Every method may raise `InputError`: the database or the disk cannot be used, or what was given is refused.
    """

    # Entering.

    def add_mould(self, path: str | Path, *, name: str | None = None, unit: str = AUTO) -> MouldRow:
        """Enter the file of a part: STL, OBJ, PLY or 3MF.

        Raises:
            MouldError: it is no surface that can be worked.
        """
        return self.enter(lambda folder: read_mould(_source(path), folder, unit), name)

    def add_tool(self, tool: PolishingTool, *, name: str) -> ToolRow:
        """Enter a tool."""
        return self.enter(lambda folder: read_tool(tool, folder, name), name)

    def add_recipe(self, path: str | Path, *, name: str | None = None) -> RecipeRow:
        """Enter a recipe in TOML."""
        return self.enter(lambda folder: read_recipe_row(_source(path), folder), name)

    def add_demonstration(self, path: str | Path, *, name: str | None = None) -> DemonstrationRow:
        """Enter a recording of ``burnish teach`` in which a demonstration was stored.

        Raises:
            RecordingError: it is none.
        """
        return self.enter(lambda folder: read_demonstration(_source(path), folder), name)

    def add_plan(self, path: str | Path, *, name: str | None = None) -> PlanRow:
        """Enter a plan of ``burnish plan``.

        Raises:
            PlanError: it is none.
        """
        return self.enter(lambda folder: read_plan_row(_source(path), folder), name)

    def add_run(self, folder: str | Path, *, name: str | None = None) -> RunRow:
        """Enter the folder of a job; a job that was gone on with gets its new figures, and stays the same row."""
        return self.enter(lambda staged: read_run(Path(folder), staged), name)

    def upload(self, file_name: str, content: bytes, *, unit: str = AUTO) -> Row:
        """Enter what somebody sent: a mould, ``.toml`` a recipe, ``.json`` a plan, ``.mcap`` a demonstration.

        Args:
            file_name: its own name, never used as a path.
            content: of the file.
            unit: of a mould.

        Raises:
            InputError: if it is of another kind, too large, or not what its name says.
        """
        called = one_line(PurePath(file_name.replace("\\", "/")).name, LONGEST_NAME)
        source, ending = Source(called=called, content=content), PurePath(called).suffix.lower()
        if ending in MESHES:
            return self.enter(lambda folder: read_mould(source, folder, unit), None)
        if ending == ".toml":
            return self.enter(lambda folder: read_recipe_row(source, folder), None)
        if ending == ".json":
            return self.enter(lambda folder: read_plan_row(source, folder), None)
        if ending == ".mcap":
            return self.enter(lambda folder: read_demonstration(source, folder), None)
        raise InputError(
            f"{called or 'a file without a name'} is nothing for the library; expected a mould ({' '.join(MESHES)}), "
            "a recipe (.toml), a plan (.json) or a demonstration (.mcap)"
        )

    # Finding; the newest first, without what lies in the bin.

    def moulds(self, search: str = "", *, tag: str | None = None, limit: int = 50, offset: int = 0) -> list[MouldRow]:
        """Moulds in which all words of ``search`` occur."""
        return self.rows(MouldRow, _found(MouldRow, search, tag), limit, offset)

    def tools(self, search: str = "", *, tag: str | None = None, limit: int = 50, offset: int = 0) -> list[ToolRow]:
        """Tools, in the same way."""
        return self.rows(ToolRow, _found(ToolRow, search, tag), limit, offset)

    def recipes(self, search: str = "", *, tag: str | None = None, limit: int = 50, offset: int = 0) -> list[RecipeRow]:
        """Recipes, in the same way."""
        return self.rows(RecipeRow, _found(RecipeRow, search, tag), limit, offset)

    def demonstrations(
        self, search: str = "", *, tag: str | None = None, limit: int = 50, offset: int = 0
    ) -> list[DemonstrationRow]:
        """Demonstrations, in the same way."""
        return self.rows(DemonstrationRow, _found(DemonstrationRow, search, tag), limit, offset)

    def plans(self, search: str = "", *, tag: str | None = None, limit: int = 50, offset: int = 0) -> list[PlanRow]:
        """Plans, in the same way."""
        return self.rows(PlanRow, _found(PlanRow, search, tag), limit, offset)

    def runs(
        self,
        search: str = "",
        *,
        tag: str | None = None,
        mould: str | None = None,
        ended: str | None = None,
        verb: str | None = None,
        since: datetime | None = None,
        limit: int = 50,
        offset: int = 0,
    ) -> list[RunRow]:
        """Runs; also those of a mould (its name or geometry), of one ending or verb, or since a moment."""
        query = _found(RunRow, search, tag)
        if mould is not None:
            query = query.where((Run.mould == mould) | (Run.mould_sha256 == mould))
        if ended is not None:
            query = query.where(Run.ended == ended)
        if verb is not None:
            query = query.where(Run.verb == verb)
        if since is not None:
            query = query.where(Entry.created >= since)
        return self.rows(RunRow, query, limit, offset)

    def count(self, kind: type[Row], search: str = "", *, tag: str | None = None) -> int:
        """How many rows such a list has in all."""
        query = select(func.count(Entry.id)).where(*_conditions(kind, search, tag))
        with self.database.session() as session:
            return session.scalar(query) or 0

    def tags(self) -> list[str]:
        """All tags that are in use."""
        with self.database.session() as session:
            return list(session.scalars(select(Tag.word).distinct().order_by(Tag.word)))

    def binned(self, limit: int = 50, offset: int = 0) -> list[Row]:
        """What lies in the bin, of all kinds, what was put there last first."""
        query = select(Entry).where(Entry.binned.is_not(None)).order_by(Entry.binned.desc(), Entry.id)
        return self.rows(Row, query, limit, offset)

    # Files.

    def file(self, row: Row, role: str | None = None) -> Path:
        """Where a file of a row lies; the main one without a role. It is only to be read.

        Raises:
            InputError: if it has none of this role, or the file is gone.
        """
        found = [stored for stored in row.files if role in (None, stored.role)]
        if not found:
            have = ", ".join(stored.role for stored in row.files) or "none"
            raise InputError(f"{row.name!r} has no file {role!r}; it has {have}")
        path = self.root / found[0].path
        if not path.is_file() or not path.resolve().is_relative_to(self.root.resolve()):
            raise InputError(f"the file {path} of {row.name!r} is missing; 'burnish db check' says what to do")
        return path

    def thumbnail(self, row: Row) -> Path | None:
        """Its picture, PNG; None where it has none."""
        return self.file(row, "thumbnail") if any(stored.role == "thumbnail" for stored in row.files) else None

    def export(self, row: Row, folder: str | Path) -> Path:
        """Copy a row's main file into a folder outside, under the row's name.

        Raises:
            InputError: if something of that name is there.
        """
        source = self.file(row)
        plain = "".join(c if c.isalnum() or c in " ._-+()" else "_" for c in row.name).strip(" .")[:80]
        target = Path(folder) / f"{plain or row.KIND}{source.suffix}"
        with disk(f"writing {target}"):
            Path(folder).mkdir(parents=True, exist_ok=True)
            with source.open("rb") as read, target.open("xb") as write:
                shutil.copyfileobj(read, write)
        return target

    # Editing; each gives the row as it is then. What was there before is in the hands of whoever called.

    def rename(self, row: R, name: str) -> R:
        """Give it another name."""
        plain = one_line(name, LONGEST_NAME)
        if not plain:
            raise InputError(f"{row.name!r} cannot be without a name; expected at least one letter")
        return self.edit(row, lambda now: replace(now, name=plain))

    def note(self, row: R, text: str) -> R:
        """Write its notes anew."""
        return self.edit(row, lambda now: replace(now, notes=several_lines(text, LONGEST_NOTES)))

    def tag(self, row: R, word: str) -> R:
        """Give it a tag."""
        plain = one_line(word, LONGEST_TAG)
        if not plain:
            raise InputError("a tag cannot be empty; expected at least one letter")
        return self.edit(row, lambda now: replace(now, tags=(*now.tags, plain)))

    def untag(self, row: R, word: str) -> R:
        """Take a tag away."""
        plain = one_line(word, LONGEST_TAG)
        return self.edit(row, lambda now: replace(now, tags=tuple(tag for tag in now.tags if tag != plain)))

    def bin(self, row: R) -> R:
        """Put it into the bin; `restore` takes it out again."""
        return self.edit(row, lambda found: replace(found, binned=found.binned or now()))

    def restore(self, row: R) -> R:
        """Take it out of the bin."""
        return self.edit(row, lambda found: replace(found, binned=None))

    def empty_bin(self) -> int:
        """Remove for good what lies in the bin, with the files that nothing else has; returns how much it was."""
        count = 0
        while rows := self.binned(limit=AT_ONCE):
            with prepared(self.root) as folder, self.writing():
                # Somebody may have taken one out, or emptied the bin, in the meantime.
                found = [self.as_it_is(row) for row in rows]
                still = [row for row in found if row is not None and row.binned is not None]
                make(self.root, self.database, folder, drop=still)
                count += len(still)
        return count

    # Upkeep.

    def check(self) -> list[audit.Finding]:
        """What is missing, altered, or too much; every file is read."""
        with self.writing():
            rows = self.everything()
            found = audit.rows_and_cards(self.root, self.database, rows)
        return [*found, *audit.contents(self.root, rows, self.as_it_is)]

    def reindex(self) -> audit.Rebuilt:
        """Build the database anew from the files and their cards; what is nobody's is moved to ``lost``."""
        with locked(self.root):
            return audit.rebuild(self.root, self.database)

    def backup(self, file: str | Path) -> int:
        """Write all of it into one archive while others go on; returns the number of rows."""
        return archive.write(self.root, self.everything(), Path(file), self.as_it_is)

    def restore_from(self, file: str | Path, *, overwrite: bool = False) -> int:
        """Put back what an archive holds; returns the number of rows.

        Raises:
            InputError: if the archive is damaged, or this library holds something and is not to be overwritten.
        """
        with prepared(self.root) as folder:
            rows = archive.read(Path(file), folder)
            with self.writing():
                before = self.everything()
                if before and not overwrite:
                    raise InputError(
                        f"the library {self.root} holds {len(before)} rows; restore into an empty one, or have it "
                        "overwritten with --overwrite"
                    )
                make(self.root, self.database, folder, put=rows, drop=before)
        return len(rows)


def _source(path: str | Path) -> Source:
    return Source(called=str(path), content=Path(path))


def _found(kind: type[Row], search: str, tag: str | None) -> Select[Entry]:
    """Such rows, the newest first; the order is that of the index."""
    query = select(TABLES[kind.KIND]).where(*_conditions(kind, search, tag))
    return query.order_by(Entry.created.desc(), Entry.id.desc())


def _conditions(kind: type[Row], search: str, tag: str | None) -> Iterator[ColumnElement[bool]]:
    """Of a kind, not in the bin, with all the words in it."""
    yield Entry.kind == kind.KIND
    yield Entry.binned.is_(None)
    for word in one_line(search, LONGEST_NAME).casefold().split():
        plain = word.replace("\\", r"\\").replace("%", r"\%").replace("_", r"\_")
        yield Entry.words.like(f"%{plain}%", escape="\\")
    if tag is not None:
        yield Entry.tags.any(Tag.word == tag)
