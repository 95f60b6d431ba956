"""Pictures of a demonstration before and after its clean-up, and of a replay, on one page each."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from burnish.analysis.atomic import write_atomically
from burnish.analysis.metrics import Scalar
from burnish.analysis.page import drawing, page, pairs, section
from burnish.analysis.plot import MEASURED, SET, TRUE, new_figure, svg
from burnish.teach.cleanup import Taught, contact_points
from burnish.teach.judge import Followed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIMULATED = "All figures on this page are simulated: no real arm has moved."
CLEANED = (
    "Above: the path over the mould, seen from above, as it was measured and as it is replayed. Below: the force along "
    "it, as it was felt in every cycle and as it was fitted to places. Contacts one behind the other."
)
REPLAYED = (
    "Above: the force that was shown and the true contact force of every repeat, along the path. Below: how far the "
    "true contact was from where it was shown, over the surface."
)


def cleaned_figure(taught: Taught, tip_radius: float) -> Figure:
    """The demonstration before and after its clean-up."""
    figure = new_figure(height=7.0)
    path, force = figure.subplots(2, 1, height_ratios=(2.0, 1.0))
    demonstration = taught.demonstration
    R = taught.placement.R.T @ demonstration.placement.R
    p = (demonstration.placement.points(demonstration.p) - taught.placement.p) @ taught.placement.R
    felt = demonstration.F[:, :3] @ R.T
    path.plot(*(1e3 * p[:, :2].T), color=MEASURED, linewidth=0.8, label="tool, as measured")
    offset = 0.0
    for number, piece in enumerate(taught.pieces):
        point = contact_points(piece, tip_radius) if piece.contact else piece.p
        style = ("-", "contact, as replayed") if piece.contact else (":", "free, as replayed")
        first = number == next(i for i, other in enumerate(taught.pieces) if other.contact == piece.contact)
        path.plot(*(1e3 * point[:, :2].T), color=TRUE, linewidth=1.2, linestyle=style[0],
                  label=style[1] if first else None)  # fmt: skip
        if not piece.contact:
            continue
        nodes = piece.ds * np.arange(len(piece.p))
        normal = np.column_stack([np.interp(piece.length, nodes, column) for column in piece.normal.T])
        pressing = np.einsum("ij,ij->i", felt[piece.samples], normal)
        label = offset == 0.0
        force.plot(1e3 * (offset + piece.length), pressing, color=MEASURED, linewidth=0.7,
                   label="felt" if label else None)  # fmt: skip
        force.plot(1e3 * (offset + nodes), piece.force, color=TRUE, linewidth=1.4, label="fitted" if label else None)
        offset += float(nodes[-1])
    path.set_aspect("equal", adjustable="datalim")
    path.set_xlabel("x of the mould [mm]")
    path.set_ylabel("y of the mould [mm]")
    force.set_xlabel("length of the path in contact [mm]")
    force.set_ylabel("force [N]")
    _finish(figure)
    return figure


def replayed_figure(found: Followed) -> Figure:
    """Force and deviation of all repeats along the path."""
    figure = new_figure(height=5.5)
    force, aside = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    for k in np.unique(found.repeat):
        mine = found.repeat == k
        order = np.argsort(found.along[mine], kind="stable")
        label = "true contact force, each repeat" if k == 1 else None
        force.plot(1e3 * found.along[mine][order], found.force[mine][order], color=TRUE, linewidth=0.6, label=label)
        aside.plot(1e3 * found.along[mine][order], 1e3 * found.aside[mine][order], color=TRUE, linewidth=0.6)
    mine = found.repeat == found.repeat.min()
    order = np.argsort(found.along[mine], kind="stable")
    force.plot(1e3 * found.along[mine][order], found.shown[mine][order], color=SET, linewidth=1.2, linestyle="--",
               label="shown")  # fmt: skip
    force.set_ylabel("force [N]")
    aside.set_ylabel("off the path [mm]")
    aside.set_xlabel("length of the path in contact [mm]")
    _finish(figure)
    return figure


def write_page(
    path: Path,
    title: str,
    outcome: str,
    figures: Mapping[str, tuple[Figure, str]],
    metrics: Mapping[str, Scalar],
    about: Mapping[str, Scalar],
) -> None:
    """Write the report as one HTML file, whole or not at all.

    Args:
        path: of the file.
        title: headline.
        outcome: how the run ended.
        figures: heading to figure and caption.
        metrics: the figures of ``metrics.json``.
        about: what was asked for, and the versions.
    """
    kind = outcome if outcome in ("done", "interrupted") else "stopped"
    head = (
        f'<header><h1>{escape(title)}</h1><span class="verdict {kind}">{escape(outcome.capitalize())}</span>'
        f'<p class="note">{SIMULATED}</p></header>'
    )
    drawings = [
        section(heading, drawing(svg(figure, heading), caption)) for heading, (figure, caption) in figures.items()
    ]
    body = (head, *drawings, section("All figures", pairs(metrics)), section("Asked for, and versions", pairs(about)))
    write_atomically(path, page(f"{title} – {outcome}", body).encode())


def _finish(figure: Figure) -> None:
    for axes in figure.axes:
        axes.grid(True, color="#e3e6ea", linewidth=0.6)
        axes.set_axisbelow(True)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper right")
