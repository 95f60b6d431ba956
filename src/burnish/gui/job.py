"""The tab Job: mould, recipe, plan, result."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import viser

from burnish.errors import InputError
from burnish.gui import part as parts
from burnish.gui import theme, words
from burnish.gui.controls import allow, put
from burnish.gui.part import Part
from burnish.gui.planning import Preview
from burnish.gui.stage import Offer, Stage, may_edit
from burnish.gui.wish import ARMS, FEED_MM_S, FORCE_N, OWN, PACES, SENSORS, SHOWN, Wish
from burnish.library import MouldRow
from burnish.polish.recipe import MOST_PASSES

if TYPE_CHECKING:
    from burnish.gui.page import Page

CHOOSE = "choose a mould …"
UNITS = ("auto", "mm", "m", "inch")
NO_PLAN = "Not planned yet."
NO_RESULT = "No result yet."
HINTS = {
    "choice": "moulds of the library and those that come with burnish",
    "upload": "it is kept in the library",
    "unit": "of the next upload; auto: found from the part's size",
    "force": "with which the tip presses",
    "feed": "speed of the tip over the surface",
    "pattern": "how the surface is covered",
    "passes": "how often all of it is done",
    "arm": "what the simulated arm suffers from",
    "sensor": "where the contact force comes from",
    "seed": "of all random errors",
    "pace": "how the simulated arm keeps to the clock",
    "mend": "a job of its own over the places that are under target; the tool of the recipe has to spin",
    "keep": "to take it again in the tab Library",
}
"""Controls that choose and edit, and what each is."""
NOTHING_BEFORE = Offer(may=False, why="there is no edit to undo")


class JobTab:
    """From the mould to the result."""

    def __init__(self, page: Page) -> None:
        """Build it in the container that is open."""
        self._page, self._bench, gui = page, page.bench, page.gui
        self._offered: dict[str, str] = {}
        with gui.add_folder("1 · Mould"):
            self.choice = gui.add_dropdown("mould", (CHOOSE,))
            self.upload = gui.add_upload_button("Upload STL, OBJ, PLY or 3MF", mime_type=".stl,.obj,.ply,.3mf")
            self.unit = gui.add_dropdown("unit of the file", UNITS)
            self.about = gui.add_html("")
        with gui.add_folder("2 · Recipe"):
            self.force = gui.add_number("force [N]", 10.0, min=FORCE_N[0], max=FORCE_N[1], step=0.5)
            self.feed = gui.add_number("feed [mm/s]", 20.0, min=FEED_MM_S[0], max=FEED_MM_S[1], step=1.0)
            self.pattern = gui.add_dropdown("pattern", (*SHOWN, OWN))
            self.passes = gui.add_number("times over", 1, min=1, max=MOST_PASSES, step=1)
            self.undo = gui.add_button("Undo the last edit", icon=viser.Icon.ARROW_BACK_UP, color="gray")
            self.redo = gui.add_button("Redo", icon=viser.Icon.ARROW_FORWARD_UP, color="gray")
            with gui.add_folder("Keep this recipe", expand_by_default=False):
                self.name = gui.add_text("name", "my recipe")
                self.keep = gui.add_button("Put it into the library")
            with gui.add_folder("Simulation", expand_by_default=False):
                self.arm = gui.add_dropdown("arm", tuple(ARMS))
                self.sensor = gui.add_dropdown("feels force", tuple(SENSORS))
                self.pace = gui.add_dropdown("pace", tuple(PACES))
                self.seed = gui.add_number("seed", 0, min=0, max=10**6, step=1)
        with gui.add_folder("3 · Plan"):
            self.plan = gui.add_html(theme.text(NO_PLAN, dim=True))
        with gui.add_folder("4 · Result"):
            self.result = gui.add_html(theme.text(NO_RESULT, dim=True))
            self.mend = gui.add_button("Repair what is under target", visible=False)
        self._listen()
        self.offer_moulds()

    def _listen(self) -> None:
        act, edit = self._page.act, self._edit
        self.choice.on_update(self._chosen)
        self.upload.on_upload(act(self._uploaded))
        self.force.on_update(edit(lambda wish: wish.with_force(self.force.value)))
        self.feed.on_update(
            edit(lambda wish: wish if _feed(wish) == self.feed.value else wish.with_feed(self.feed.value))
        )
        self.pattern.on_update(edit(lambda wish: wish.with_pattern(self.pattern.value)))
        self.passes.on_update(edit(lambda wish: wish.with_passes(int(self.passes.value))))
        self.arm.on_update(edit(lambda wish: wish.on(arm=ARMS[self.arm.value])))
        self.sensor.on_update(edit(lambda wish: wish.on(sensor=SENSORS[self.sensor.value])))
        self.pace.on_update(edit(lambda wish: wish.on(pace=PACES[self.pace.value])))
        self.seed.on_update(edit(lambda wish: wish.on(seed=int(self.seed.value))))
        self.undo.on_click(act(lambda event: self._bench.undo()))
        self.redo.on_click(act(lambda event: self._bench.redo()))
        self.mend.on_click(act(lambda event: self._bench.repair(event.client_id)))
        self.keep.on_click(act(lambda event: self._bench.keep_recipe(self.name.value)))

    def offer_moulds(self) -> None:
        """Take up what the library has now."""
        self._offered = parts.choices(self._bench.library)
        names = (CHOOSE, *self._offered)
        if tuple(self.choice.options) != names:
            self.choice.options = names

    def refresh(self) -> None:
        """Show the bench as it is now."""
        bench, wish = self._bench, self._bench.edits.now
        self.offer_moulds()
        may = may_edit(bench.stage, self._page.command.mine)
        for handle, hint in HINTS.items():
            allow(getattr(self, handle), may, hint)
        allow(self.undo, may if bench.edits.before else NOTHING_BEFORE)
        put(self.redo, visible=bool(bench.edits.undone))
        allow(self.redo, may)
        put(self.force, value=wish.recipe.force)
        put(self.feed, value=_feed(wish))
        put(self.pattern, value=wish.pattern)
        put(self.passes, value=wish.passes)
        put(self.arm, value=next(shown for shown, name in ARMS.items() if name == wish.arm))
        put(self.sensor, value=next(shown for shown, name in SENSORS.items() if name == wish.sensor))
        put(self.seed, value=wish.seed)
        put(self.pace, value=next(shown for shown, pace in PACES.items() if pace == wish.pace))
        put(self.mend, visible=bench.stage is Stage.DONE and bench.line[:1] == ["polish"])
        part = bench.part
        if part is not None and part.name in self._offered:
            put(self.choice, value=part.name)
        put(self.about, content="" if part is None else theme.text(part.says, dim=True))
        put(self.plan, content=planned(bench.stage, bench.preview))
        put(self.result, content=reached(bench.stage, bench.metrics))

    def _edit(self, change: Callable[[Wish], Wish]) -> Callable[[Any], None]:
        """A callback that edits; showing what is so already is no edit."""
        act = self._page.act(lambda event: self._bench.edit(change))

        def edited(event: Any) -> None:
            try:
                new = change(self._bench.edits.now) != self._bench.edits.now
            except InputError:
                new = True
            if new:
                act(event)

        return edited

    def _chosen(self, event: Any) -> None:
        name = self.choice.value
        if name != CHOOSE and (self._bench.part is None or self._bench.part.name != name):
            self._page.act(lambda event: self._mount(name))(event)

    def _mount(self, name: str) -> None:
        if name not in self._offered:
            raise InputError(f"the mould {name!r} is gone; choose another one")
        self._bench.mount(parts.named(self._bench.library, self._offered[name]))

    def _uploaded(self, event: Any) -> None:
        file = self.upload.value
        row = self._bench.library.upload(file.name, file.content, unit=self.unit.value)
        if not isinstance(row, MouldRow):
            raise InputError(f"{file.name} is no mould; expected an STL, OBJ, PLY or 3MF file")
        self._bench.mount(Part.of_row(self._bench.library, row))


def planned(stage: Stage, preview: Preview | None) -> str:
    """The plan in words."""
    if preview is None:
        return theme.text("Being planned …" if stage is Stage.PLANNING else NO_PLAN, dim=True)
    if preview.refusal is not None:
        at = " The red mark on the part shows where." if preview.refusal.at is not None else ""
        remedy = f" What helps: {preview.refusal.remedy}" if preview.refusal.remedy else ""
        place = f"{preview.refusal.where}. " if preview.refusal.where else ""
        return theme.notice(f"{place}{preview.refusal.why}{remedy}{at}", "red", "The arm cannot do this")
    rows = [
        ("strokes", str(len(preview.strokes))),
        ("path", f"{preview.length:.2f} m"),
        ("time on the surface", words.duration(preview.duration)),
        ("planned depth", f"{1e6 * preview.target:.3f} µm"),
    ]
    notes = "".join(theme.text(f"Note: {note}.", dim=True) for note in preview.notes)
    return theme.table(rows) + notes


def reached(stage: Stage, metrics: Any) -> str:
    """What the job reached, in words."""
    rows = words.figures(metrics)
    if not rows:
        return theme.text(NO_RESULT, dim=True)
    return theme.table(rows) + theme.text("All simulated.", dim=True)


def _feed(wish: Wish) -> float:
    """As the page shows it [mm/s]."""
    return round(1e3 * wish.recipe.feed, 6)
