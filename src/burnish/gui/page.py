"""What one browser tab shows: the state, the button that leads on, the stop, and a tab for each thing to do."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import viser

from burnish.gui import stage as stages
from burnish.gui import theme, words
from burnish.gui.arm import ArmTab
from burnish.gui.bench import Bench
from burnish.gui.catalogue import LibraryTab
from burnish.gui.controls import WatchingError, allow, guarded, notify, put
from burnish.gui.job import JobTab
from burnish.gui.live import LiveTab
from burnish.gui.stage import Offer, Stage
from burnish.gui.teach import TeachTab
from burnish.runtime.mailbox import Glance

STILL = 1.0
"""Age of a glance from which on no arm moves [s]: a job plans before and judges after it."""
WATCHES = "This tab only watches; the controls are off until it commands."


class Command(Protocol):
    """One viewer's share in the command, of which there is one."""

    @property
    def mine(self) -> bool:
        """Whether this viewer commands."""

    @property
    def free(self) -> bool:
        """Whether nobody does."""

    def take(self) -> None:
        """Take it, if it is free.

        Raises:
            BurnishError: it is not.
        """


class Page:
    """The panel of one viewer."""

    def __init__(self, gui: viser.GuiApi, bench: Bench, command: Command) -> None:
        """Build it.

        Args:
            gui: of the viewer's browser tab.
            bench: what all viewers look at.
            command: whether this viewer is the commander, and how to become it.
        """
        self.gui, self.bench, self.command = gui, bench, command
        self._shown: tuple[Any, ...] = ()
        self.looked = -1
        """How much of the bench's changes this page has shown."""
        self.headline = gui.add_html("")
        self.lead = gui.add_button("Take command", icon=viser.Icon.HAND_STOP, visible=False)
        self.step = gui.add_button("Plan")
        self.stop = gui.add_button("Stop", color="red", icon=viser.Icon.PLAYER_STOP_FILLED)
        # However far the page is scrolled.
        self.stop_key = gui.add_command("Stop the job", hotkey="escape", icon=viser.Icon.PLAYER_STOP_FILLED)
        gui.add_html(theme.text(words.NO_EMERGENCY_STOP, dim=True))
        self.report = gui.add_html("", visible=False)
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.trouble = gui.add_html("", visible=False)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Job", viser.Icon.TOOL):
            self.job = JobTab(self)
        with tabs.add_tab("Live", viser.Icon.ACTIVITY):
            self.live = LiveTab(self)
        with tabs.add_tab("Library", viser.Icon.BOOKS):
            self.library = LibraryTab(self)
        with tabs.add_tab("Teach", viser.Icon.SCHOOL):
            self.teach = TeachTab(self)
        with tabs.add_tab("Arm", viser.Icon.ROBOT):
            self.arm = ArmTab(self)
        self.dark = gui.add_checkbox("Dark page", False)
        self.dark.on_update(lambda event: theme.configure(gui, self.dark.value))
        self.lead.on_click(guarded(self.tell, self._take))
        self.step.on_click(self.act(self._lead_on))
        self.stop.on_click(self.act(lambda event: bench.stop()))
        self.stop_key.on_trigger(self.act(lambda event: bench.stop()))
        self.refresh(None)

    def act(self, do: Callable[[Any], object]) -> Callable[[Any], None]:
        """A callback that only the commander may cause."""

        def checked(event: Any) -> None:
            if not self.command.mine:
                raise WatchingError(f"{stages.WATCHER[:1].upper()}{stages.WATCHER[1:]}.")
            self.command.take()
            do(event)
            self.refresh(self.bench.glance())

        return guarded(self.tell, checked)

    def tell(self, client: viser.ClientHandle | None, sentence: str) -> None:
        """Show a refusal."""
        notify(client, sentence)
        put(self.trouble, content=theme.notice(sentence, "orange"), visible=True)

    def refresh(self, glance: Glance | None) -> None:
        """Show what has changed since the last time."""
        bench = self.bench
        stage, commands = bench.stage, self.command.mine
        step, may = stages.step(stage, commands)
        sentence = says(bench, glance) + ("" if commands else f" {WATCHES}")
        put(self.headline, content=theme.headline(chips(bench, glance, commands), sentence))
        done = progress(bench, glance)
        put(self.progress, visible=done is not None)
        if done is not None:
            put(self.progress, value=round(100.0 * done))
        put(self.lead, visible=not commands)
        allow(self.lead, Offer(may=self.command.free, why="" if self.command.free else stages.WATCHER))
        waits = glance.waits_for if glance is not None and bench.live else ()
        now = (bench.looked, stage, commands, waits)
        if now == self._shown:
            return
        self._shown, self.looked = now, bench.looked
        put(self.step, label=step.label)
        allow(self.step, may)
        may_stop = stages.may_stop(stage, commands)
        allow(self.stop, may_stop)
        put(self.stop_key, disabled=not may_stop.may)
        put(
            self.trouble,
            content=theme.notice(bench.trouble, "orange") if bench.trouble else "",
            visible=bool(bench.trouble),
        )
        report = bench.report if not bench.live else None
        button = "" if report is None else theme.link_button("Open the report", f"/report/{report.parent.name}")
        put(self.report, visible=report is not None, content=button)
        self.job.refresh()
        self.library.refresh()
        self.teach.refresh(glance)
        self.arm.refresh()

    def draw(self) -> None:
        """The curves, a few times a second."""
        self.live.draw()

    def _take(self, event: Any) -> None:
        self.command.take()
        self.refresh(self.bench.glance())

    def _lead_on(self, event: Any) -> None:
        """The button that leads on, whatever it says now."""
        bench = self.bench
        match bench.stage:
            case Stage.CHOSEN | Stage.REFUSED | Stage.FAILED:
                bench.plan()
            case Stage.PLANNING:
                bench.cancel_plan()
            case Stage.READY | Stage.DONE:
                bench.start(event.client_id)
            case Stage.RUNNING:
                bench.pause()
            case Stage.PAUSED:
                bench.resume(event.client_id)
            case _:
                pass


def chips(bench: Bench, glance: Glance | None, commands: bool) -> list[tuple[str, str]]:
    """The state in two words: of the arm, and of this tab."""
    if bench.live and glance is not None:
        arm = words.MODES[glance.mode]
    elif bench.live:
        arm = ("starts", "blue")
    else:
        arm = ("at rest", "gray")
    return [("simulated arm: " + arm[0], arm[1]), ("you command", "blue") if commands else ("you watch", "gray")]


def says(bench: Bench, glance: Glance | None) -> str:
    """Where the job stands, in one sentence."""
    step = stages.STEPS[bench.stage]
    if bench.stage is Stage.PLANNING:
        return f"Nothing moves. Being done: {bench.planner.stage or 'starting'}."
    if not bench.live:
        return step.says
    job = bench.job
    stage = job.box.stage if job is not None else ""
    if glance is None or time.monotonic() - glance.wall > STILL:
        return f"Nothing moves. Being done: {stage or 'starting the job'}."
    what = f"The arm {words.phase(glance.phase)}"
    if glance.strokes > 1:
        what += f", stroke {min(glance.stroke + 1, glance.strokes)} of {glance.strokes}"
    what += "." if bench.taught else f"; {100.0 * glance.done:.0f} % of the work is done."
    if glance.cause:
        what = f"Held: {glance.cause}."
    return f"{what} {step.says}" if bench.stage is Stage.ENDING else what


def progress(bench: Bench, glance: Glance | None) -> float | None:
    """Share of what is under way, 0 to 1; None if nothing is."""
    if bench.stage is Stage.PLANNING:
        return bench.planner.share
    if bench.live and not bench.taught:
        return 0.0 if glance is None else glance.done
    return None
