"""The tab Live: what the arm does now, against what it shall do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from burnish.gui import theme, words
from burnish.gui.paint import FULL, scale
from burnish.gui.plots import Plots
from burnish.runtime.mailbox import Glance

if TYPE_CHECKING:
    from burnish.gui.page import Page

IDLE = "No job runs. The last one stays on the screen."
SIMULATED = "simulated JACO2 (no arm is connected)"


class LiveTab:
    """Curves, the state in full, and what the colours mean."""

    def __init__(self, page: Page) -> None:
        """Build it in the container that is open."""
        self._page = page
        self.plots = Plots(page.gui)
        self.state = page.gui.add_html(theme.text(IDLE, dim=True))
        page.gui.add_html(legend())
        self._glance: Glance | None = None

    def add(self, glance: Glance, margin: float) -> None:
        """A new look at the arm; ``margin`` is the distance to its nearest joint limit [rad]."""
        self._glance = glance
        self.plots.history.add(glance, margin)

    def draw(self) -> None:
        """Curves and state."""
        self.plots.draw()
        if self._glance is not None:
            self.state.content = theme.table(rows(self._glance))


def rows(glance: Glance) -> list[tuple[str, str]]:
    """The state in words and figures."""
    return [
        ("arm", SIMULATED),
        ("supervisor", words.MODES[glance.mode][0]),
        ("held because", glance.cause or "–"),
        ("it", words.phase(glance.phase)),
        ("stroke", f"{min(glance.stroke + 1, glance.strokes)} of {glance.strokes}" if glance.strokes else "–"),
        ("force, set", f"{words.number(glance.force, 'N', 2)}, {words.number(glance.force_set, 'N', 2)}"),
        ("speed, set", f"{words.number(1e3 * glance.feed, 'mm/s')}, {words.number(1e3 * glance.feed_set, 'mm/s')}"),
        ("tilt error", words.number(words.degrees(glance.tilt), "°", 2)),
        ("time of the arm", words.duration(glance.t)),
        ("late cycles", str(glance.late_cycles)),
    ]


def legend() -> str:
    """What the colours on the mould mean."""
    colours = [f"rgb({red},{green},{blue})" for red, green, blue in (_srgb(k) for k in range(0, 256, 15))]
    marks = [(0.0, "untouched"), (0.5 / FULL, "½"), (1.0 / FULL, "as planned"), (1.0, "too much")]
    return theme.legend(colours, marks, "Removed so far, by the planned depth (estimated from force and path)")


def _srgb(level: int) -> tuple[int, int, int]:
    """A colour of the scale for a screen."""
    light = scale()[level, :3] / 255.0
    screen = [12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055 for v in light.tolist()]
    red, green, blue = (round(255.0 * v) for v in screen)
    return red, green, blue
