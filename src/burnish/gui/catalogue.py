"""The tab Library: find, look, name, compare, export, throw away and take back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import viser

from burnish.errors import InputError
from burnish.gui import entries, theme
from burnish.gui.controls import allow, guarded, put
from burnish.gui.entries import ANY_TAG, BIN, KINDS
from burnish.gui.part import Part
from burnish.gui.stage import BUSY, Offer, may_edit
from burnish.library import MouldRow, RecipeRow, Row, RunRow
from burnish.polish.recipe_file import read_recipe

if TYPE_CHECKING:
    from burnish.gui.page import Page

NONE = "–"
EMPTY = "Nothing is found. What is uploaded, planned, taught and polished is entered by itself."
RESUMABLE = ("stopped", "interrupted", "paused", "lost")
"""How a run may have ended that can be gone on with."""
OPENED = {"report": "Open the report", "part": "Open the page for the customer"}
STORED = {
    "recording": "Store the recording (MCAP)",
    "mesh": "Store the mesh",
    "recipe": "Store the recipe (TOML)",
    "plan": "Store the plan (JSON)",
}
"""What the link to each file of an entry says."""
MORE = "Only the latest 50 are listed; search for others."


class LibraryTab:
    """One list and one entry of it."""

    def __init__(self, page: Page) -> None:
        """Build it in the container that is open."""
        self._page, self._library, gui = page, page.bench.library, page.gui
        self._rows: dict[str, Row] = {}
        self._before: list[Row] = []
        self.row: Row | None = None
        self.kind = gui.add_dropdown("show", (*KINDS, BIN))
        self.search = gui.add_text("search", "", hint="words of the name, notes and tags")
        self.tag = gui.add_dropdown("tag", (ANY_TAG,))
        self.entry = gui.add_dropdown("entry", (NONE,))
        self.found = gui.add_html("")
        self.use = gui.add_button("Put onto the bench", visible=False)
        self.picture = gui.add_html("", visible=False)
        self.about = gui.add_html("")
        self.links = gui.add_html("", visible=False)
        with gui.add_folder("Name, tags and notes", expand_by_default=False):
            self.name = gui.add_text("name", "")
            self.tags = gui.add_text("tags", "", hint="with commas between them")
            self.notes = gui.add_text("notes", "", multiline=True)
            self.save = gui.add_button("Save")
            self.undo = gui.add_button("Undo the last change", color="gray")
        with gui.add_folder("Compare with", expand_by_default=False):
            self.other = gui.add_dropdown("other run", (NONE,))
            self.compared = gui.add_html("")
        self.throw = gui.add_button("Put into the bin", color="gray", icon=viser.Icon.TRASH)
        self.empty = gui.add_button("Empty the bin for good", color="red", visible=False)
        self._listen()
        self.reload()

    def _listen(self) -> None:
        look = self._look
        for handle in (self.kind, self.search, self.tag):
            handle.on_update(look(lambda event: self.reload()))
        self.entry.on_update(look(lambda event: self._chosen()))
        self.other.on_update(look(lambda event: self._compare()))
        act = self._page.act
        self.use.on_click(act(self._use))
        self.save.on_click(act(lambda event: self._save()))
        self.undo.on_click(act(lambda event: self._undo()))
        self.throw.on_click(act(lambda event: self._throw()))
        self.empty.on_click(act(lambda event: self._empty()))

    def reload(self) -> None:
        """List anew, and keep the entry if it is still there."""
        tags = (ANY_TAG, *self._library.tags())
        put(self.tag, options=tags)
        rows = entries.found(self._library, self.kind.value, self.search.value, self.tag.value)
        self._rows = entries.labels(rows)
        kept = next(
            (label for label, row in self._rows.items() if self.row is not None and row.id == self.row.id), None
        )
        names = tuple(self._rows) or (NONE,)
        put(self.entry, options=names)
        put(self.entry, value=kept or names[0])
        put(self.found, content="" if rows else theme.text(EMPTY, dim=True))
        if len(rows) == entries.LISTED:
            put(self.found, content=theme.text(MORE, dim=True))
        put(self.empty, visible=self.kind.value == BIN and bool(rows))
        self._chosen()

    def refresh(self) -> None:
        """What may be done follows the bench."""
        stage, mine = self._page.bench.stage, self._page.command.mine
        may = may_edit(stage, mine)
        for handle in (self.use, self.save, self.throw, self.empty):
            allow(handle, may)
        allow(self.undo, may if self._before else Offer(may=False, why="nothing was changed here"))
        if stage not in BUSY:
            self.reload()

    def _chosen(self) -> None:
        """Show the entry."""
        row = self._rows.get(self.entry.value)
        if row is not None and row == self.row:
            return
        self.row = row
        put(self.about, content="" if row is None else theme.table(entries.details(row)))
        picture = None if row is None else self._library.thumbnail(row)
        shown = "" if row is None or picture is None else theme.picture(f"/thumb/{row.id}", f"picture of {row.name}")
        put(self.picture, visible=bool(shown), content=shown)
        links = "" if row is None else "".join(theme.link(*one) for one in self._addresses(row))
        put(self.links, content=links, visible=bool(links))
        put(self.use, visible=isinstance(row, MouldRow | RecipeRow) or _resumable(row), label=_use(row))
        put(self.name, value="" if row is None else row.name)
        put(self.tags, value="" if row is None else ", ".join(row.tags))
        put(self.notes, value="" if row is None else row.notes)
        put(
            self.throw,
            visible=row is not None,
            label="Take out of the bin" if row and row.binned else "Put into the bin",
        )
        runs = tuple(label for label, one in self._rows.items() if isinstance(one, RunRow) and one != row)
        put(self.other, options=(NONE, *runs))
        self._compare()

    def _addresses(self, row: Row) -> list[tuple[str, str]]:
        """Words and addresses of what can be opened or stored."""
        roles = [file.role for file in row.files]
        return [(says, f"/{role}/{row.id}") for role, says in (OPENED | STORED).items() if role in roles]

    def _compare(self) -> None:
        other = self._rows.get(self.other.value)
        if not isinstance(self.row, RunRow) or not isinstance(other, RunRow):
            put(self.compared, content=theme.text("Choose a run above and another one here.", dim=True))
            return
        rows = entries.compared(self.row, other)
        put(self.compared, content=theme.table(rows, ("", self.row.name, other.name)))

    def _use(self, event: Any) -> None:
        bench, row = self._page.bench, self.row
        if isinstance(row, MouldRow):
            bench.mount(Part.of_row(self._library, row))
        elif isinstance(row, RecipeRow):
            recipe = read_recipe(self._library.file(row, "recipe"))
            bench.edit(lambda wish: wish.on(recipe=recipe))
        elif isinstance(row, RunRow):
            bench.resume(event.client_id, bench.folder_of(row))

    def _save(self) -> None:
        row = self._held()
        wanted = {word.strip() for word in self.tags.value.split(",") if word.strip()}
        changed = self._library.rename(row, self.name.value)
        changed = self._library.note(changed, self.notes.value)
        for word in sorted(wanted - set(changed.tags)):
            changed = self._library.tag(changed, word)
        for word in sorted(set(changed.tags) - wanted):
            changed = self._library.untag(changed, word)
        self._changed(row)

    def _throw(self) -> None:
        row = self._held()
        if row.binned is None:
            self._library.bin(row)
        else:
            self._library.restore(row)
        self._changed(row)

    def _undo(self) -> None:
        """The last change of an entry is taken back, its place in the bin too."""
        before = self._before.pop()
        now = self._library.get(type(before), before.id)
        now = self._library.note(self._library.rename(now, before.name), before.notes)
        for word in sorted(set(before.tags) - set(now.tags)):
            now = self._library.tag(now, word)
        for word in sorted(set(now.tags) - set(before.tags)):
            now = self._library.untag(now, word)
        if (now.binned is None) != (before.binned is None):
            now = self._library.restore(now) if before.binned is None else self._library.bin(now)
        self.row = None
        self.reload()

    def _empty(self) -> None:
        self._library.empty_bin()
        self._before.clear()
        self.row = None
        self.reload()

    def _changed(self, before: Row) -> None:
        self._before.append(before)
        self.row = None
        self.reload()

    def _held(self) -> Row:
        if self.row is None:
            raise InputError("no entry is chosen; choose one first")
        return self.row

    def _look(self, do: Any) -> Any:
        """A callback that changes nothing but what this page shows."""
        return guarded(self._page.tell, do)


def _use(row: Row | None) -> str:
    """What the button does with an entry."""
    if isinstance(row, RecipeRow):
        return "Take this recipe"
    return "Go on with this job" if isinstance(row, RunRow) else "Put onto the bench"


def _resumable(row: Row | None) -> bool:
    return isinstance(row, RunRow) and row.verb == "polish" and row.ended in RESUMABLE
