"""The plot of an experiment: the errors of its trials over time, one column an arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from burnish.analysis.plot import envelope, new_figure, svg
from burnish.core import Array
from burnish.trials.experiment import Trial
from burnish.trials.outcome import arm_name
from burnish.trials.record import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0b4f8a", "#d55e00", "#009e73", "#cc79a7", "#e8a23a", "#56b4e9", "#222222", "#8c6d31")
"""Told apart by everybody; further lines are dashed."""
BINS = 150
"""Intervals of a line, each drawn by its extremes."""
MOST = 48
"""Trials of a plot."""
FLOOR = 1e-3
"""Smallest error that is drawn [mm, deg, mrad]: what is below is nobody's concern."""


def errors_svg(name: str, trials: Sequence[Trial], records: Mapping[str, Record]) -> str:
    """Errors of the tool, and of the joints where they have a reference, as an ``<svg>``.

    Empty without a record, and with more trials than lines can be told apart: their table says more.
    """
    done = [trial for trial in trials if trial.name in records]
    if not done or len(done) > MOST:
        return ""
    arms = [arm for arm in ("ideal", "ideal, with rotors", "honest") if any(arm_name(t.arm) == arm for t in done)]
    joints = not all(np.isnan(np.asarray(records[trial.name].joint_error)).all() for trial in done)
    figure = new_figure(height=2.3 * (2 + joints) + 0.2 * len(done) / len(arms) + 0.3)
    grid = figure.subplots(2 + joints, len(arms), sharex=True, sharey="row", squeeze=False)
    for column, arm in enumerate(arms):
        here = [trial for trial in done if arm_name(trial.arm) == arm]
        for k, trial in enumerate(here):
            for axes, values in zip(grid[:, column], _errors(records[trial.name], joints), strict=True):
                _line(axes, records[trial.name].time, values, trial.name, k, stopped=bool(records[trial.name].stopped))
        grid[0, column].set_title(arm)
        grid[-1, column].set_xlabel("time [s]")
        handles, labels = grid[0, column].get_legend_handles_labels()
        grid[-1, column].legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=1)
    for axes, label in zip(
        grid[:, 0], ("position error [mm]", "orientation error [°]", "joint error [mrad]"), strict=False
    ):
        axes.set_ylabel(label)
    figure.align_ylabels()
    return svg(figure, name)


def _errors(record: Record, joints: bool) -> list[Array]:
    """Of position [mm], orientation [deg] and, if asked for, joints [mrad] over time."""
    errors = [1e3 * record.position_error, np.degrees(record.orientation_error)]
    if joints:
        errors.append(1e3 * np.linalg.norm(np.asarray(record.joint_error), axis=1))
    return errors


def _line(axes: Axes, t: Array, values: Array, label: str, number: int, *, stopped: bool) -> None:
    colour, style = COLOURS[number % len(COLOURS)], "-" if number < len(COLOURS) else "--"
    x, y = envelope(t, np.maximum(values, FLOOR), BINS)
    axes.semilogy(x, y, color=colour, linewidth=1.0, linestyle=style, label=label)
    axes.minorticks_off()  # On a logarithmic scale they take most of the drawing time.
    if stopped:
        axes.plot(x[-1:], y[-1:], marker="x", markersize=7, color=colour)
    axes.grid(True, color="#e3e6ea", linewidth=0.6)
    axes.set_axisbelow(True)
