"""The tab Arm: what is connected, what it may do, and the poses in which it is calibrated."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from burnish.core import Array
from burnish.gui import theme
from burnish.gui.controls import allow, guarded, put
from burnish.gui.stage import LIVE, Offer
from burnish.hardware.calibration import TORQUE_POSES
from burnish.polish.cell import HOME
from burnish.runtime.limits import Limits

if TYPE_CHECKING:
    from burnish.gui.page import Page

PATIENCE = 120.0
"""Time that the doctor gets [s]."""
NOT_LOOKED = "Not looked at yet. Nothing is moved by looking."
POSES = ("home", "candle (thesis A)", "candle, wrist turned (thesis B)", "of the maintenance guide")
CALIBRATED = (
    "Torque sensors are zeroed in one of these poses, at rest, within 1°: there gravity turns no joint. Joint 1 may "
    "stand anywhere. How to go there and zero them: docs/jaco2-arm.md."
)
MARKS = {"ok": "green", "missing": "red", "note": "gray"}


class ArmTab:
    """The arm, as far as it is known."""

    def __init__(self, page: Page) -> None:
        """Build it in the container that is open."""
        self._page, gui = page, page.gui
        with gui.add_folder("Is everything there?"):
            self.look = gui.add_button("Ask the doctor")
            self.findings = gui.add_html(theme.text(NOT_LOOKED, dim=True))
        with gui.add_folder("Limits", expand_by_default=False):
            limits = Limits.jaco2()
            gui.add_html(theme.table(joint_limits(limits), ("joint", "from", "to", "speed", "torque")))
            gui.add_html(theme.table(other_limits(limits)))
        with gui.add_folder("Calibration poses", expand_by_default=False):
            gui.add_html(theme.text(CALIBRATED, dim=True))
            gui.add_html(theme.table(poses(), ("pose [°]", *(str(joint) for joint in range(1, 7)))))
            self.pose = gui.add_dropdown("pose", POSES)
            self.show = gui.add_button("Show it in the picture; no arm moves")
        self.look.on_click(guarded(page.tell, self._look))
        self.show.on_click(guarded(page.tell, lambda event: page.bench.pose(joints(self.pose.value))))

    def refresh(self) -> None:
        """A pose is shown only while none is live."""
        live = self._page.bench.stage in LIVE
        allow(self.show, Offer(may=not live, why="the picture follows the job" if live else ""))

    def _look(self, event: Any) -> None:
        put(self.look, disabled=True)
        put(self.findings, content=theme.text("Looking …", dim=True))
        try:
            put(self.findings, content=told(doctor()))
        finally:
            put(self.look, disabled=False)


def doctor() -> str:
    """What ``burnish doctor`` says, asked in a process of its own: a vendor's library may end the one that loads it."""
    command = [sys.executable, "-m", "burnish", "doctor"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return f"missing  an answer of the doctor within {PATIENCE:.0f} s\n"
    if found.returncode != 0:
        return f"missing  the doctor ended with status {found.returncode}: {found.stderr.strip()[-200:]}\n"
    return found.stdout


def told(text: str) -> str:
    """The doctor's lines as a page shows them."""
    parts = []
    for verdict, what, remedy in findings(text):
        parts.append(theme.headline([(verdict, MARKS[verdict])], what))
        if remedy:
            parts.append(theme.text(f"→ {remedy}", dim=True))
    return "".join(parts)


def findings(text: str) -> Iterator[tuple[str, str, str]]:
    """Verdict, what was found, and what to do, of the doctor's lines."""
    held: list[str] = []
    for line in text.splitlines():
        word, _, rest = line.partition(" ")
        if word in MARKS:
            if held:
                yield held[0], held[1], held[2]
            held = [word, rest.strip(), ""]
        elif held and line.strip().startswith("→"):
            held[2] = line.strip()[1:].strip()
    if held:
        yield held[0], held[1], held[2]


def joint_limits(limits: Limits) -> list[tuple[str, ...]]:
    """A row a joint."""
    rows = []
    for k in range(len(limits.torque)):
        low, high = np.rad2deg(limits.lower[k]), np.rad2deg(limits.upper[k])
        ends = [f"{end:.0f}°" if np.isfinite(end) else "free" for end in (low, high)]
        rows.append((str(k + 1), *ends, f"{np.rad2deg(limits.speed[k]):.0f} °/s", f"{limits.torque[k]:.1f} N·m"))
    return rows


def other_limits(limits: Limits) -> list[tuple[str, str]]:
    """What holds for the whole arm."""
    return [
        ("force of the tool", f"{limits.tool_force:.0f} N"),
        ("change of a torque", f"{limits.torque_rate:.0f} N·m/s"),
        ("fingerprint of the limits", limits.hash[:16]),
    ]


def poses() -> list[tuple[str, ...]]:
    """A row a pose [°]."""
    rows = []
    for name, pose in zip(POSES, (HOME, *TORQUE_POSES), strict=True):
        rows.append((name, *(f"{np.rad2deg(angle):.0f}" if np.isfinite(angle) else "any" for angle in pose)))
    return rows


def joints(name: str) -> Array:
    """Joint positions of a pose [rad], (6,); where any would do, that of home."""
    pose = (HOME, *TORQUE_POSES)[POSES.index(name)]
    return np.asarray(np.where(np.isfinite(pose), pose, HOME))
