"""Four small curves of the last seconds: force, tilt, speed and the distance to the nearest joint limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from burnish.core import Array
from burnish.gui.words import degrees
from burnish.runtime.glance import Glance

SECONDS = 30.0
"""What is shown, of the arm's clock [s]."""
ROWS = 300
"""Points of a curve at most."""
MEASURED, SET, LIMIT = "#1c7ed6", "#868e96", "#e03131"
"""Colours of what is, of what shall be, and of what must not be."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """One plot."""

    title: str
    """With its unit."""
    names: tuple[str, str]
    """Of the two lines."""
    low: float
    """Least top of the scale: below it nothing is blown up."""
    limit: bool = False
    """Whether the second line is one that must not be crossed."""


CURVES = (
    Curve(title="contact force [N]", names=("force", "set"), low=2.0),
    Curve(title="tilt error of the tool [°]", names=("tilt", "set"), low=2.0),
    Curve(title="speed of the tool [mm/s]", names=("speed", "set"), low=10.0),
    Curve(title="nearest joint limit [°]", names=("distance", "warns below"), low=30.0, limit=True),
)
WARNS = 10.0
"""Distance from a joint limit that a plan keeps [°]."""


class History:
    """The latest rows of what is plotted."""

    def __init__(self) -> None:
        self._rows = np.full((ROWS, 9), np.nan)
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._count = 0

    def add(self, glance: Glance, margin: float) -> None:
        """One look at the arm.

        Args:
            glance: what the job shows.
            margin: distance to the nearest joint limit [rad].
        """
        if self._count and glance.t < self.last:
            self.clear()
        # An even spacing: a look that comes too early takes the place of the last one.
        k = self._count
        if k and glance.t - self._rows[(k - 2) % ROWS, 0] < SECONDS / ROWS and k > 1:
            k -= 1
        self._rows[k % ROWS] = (
            glance.t, glance.force, glance.force_set, degrees(glance.tilt), 0.0 if np.isfinite(glance.tilt) else np.nan,
            1e3 * glance.feed, 1e3 * glance.feed_set, degrees(margin), WARNS,
        )  # fmt: skip
        self._count = k + 1

    @property
    def last(self) -> float:
        """Time of the latest row [s]."""
        return float(self._rows[(self._count - 1) % ROWS, 0]) if self._count else 0.0

    def data(self, curve: int) -> tuple[Array, Array, Array]:
        """Time and both lines of a plot, oldest first; at least one row."""
        if not self._count:
            return np.zeros(1), np.full(1, np.nan), np.full(1, np.nan)
        first = max(0, self._count - ROWS)
        rows = self._rows[np.arange(first, self._count) % ROWS]
        rows = rows[rows[:, 0] >= self.last - SECONDS]
        return rows[:, 0].copy(), rows[:, 1 + 2 * curve].copy(), rows[:, 2 + 2 * curve].copy()


def top(curve: int, *lines: Array) -> float:
    """A round end of the scale that holds the lines."""
    finite = np.concatenate([line[np.isfinite(line)] for line in lines])
    most = max(CURVES[curve].low, 1.08 * float(finite.max())) if len(finite) else CURVES[curve].low
    step = 10.0 ** np.floor(np.log10(most)) / 2.0
    return float(np.ceil(most / step) * step)


class Plots:
    """The plots on a page."""

    def __init__(self, gui: viser.GuiApi, height: int = 140) -> None:
        self.history = History()
        self._handles = []
        for number, curve in enumerate(CURVES):
            first = uplot.Series(label=curve.names[0], stroke=MEASURED, width=1.5)
            second = uplot.Series(
                label=curve.names[1], stroke=LIMIT if curve.limit else SET, width=1.2, dash=(5.0, 4.0)
            )
            self._handles.append(
                gui.add_uplot(
                    self.history.data(number),
                    (uplot.Series(label="t [s]"), first, second),
                    title=curve.title,
                    scales={"x": uplot.Scale(time=False), "y": uplot.Scale(range=(0.0, curve.low))},
                    axes=(uplot.Axis(size=34), uplot.Axis(size=42)),
                    legend=uplot.Legend(show=False),
                    height=height,
                    padding=(8, 12, 0, 0),
                )
            )
        self._tops = [curve.low for curve in CURVES]

    def draw(self) -> None:
        """Show the history as it is now."""
        for number, handle in enumerate(self._handles):
            data = self.history.data(number)
            most = top(number, *data[1:])
            if most != self._tops[number]:
                self._tops[number] = most
                handle.scales = {"x": uplot.Scale(time=False), "y": uplot.Scale(range=(0.0, most))}
            handle.data = data
