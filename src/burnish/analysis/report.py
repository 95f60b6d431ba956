"""The report of one run: a single HTML file that needs nothing else, for people to look at and to keep."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from burnish.analysis.atomic import write_atomically
from burnish.analysis.glossary import GLOSSARY, HEADLINE, Meaning, figure
from burnish.analysis.metrics import Scalar
from burnish.analysis.mould_map import RemovalField, coverage_map, removal_histogram, removal_map
from burnish.analysis.page import card, drawing, page, pairs, picture, section, table
from burnish.analysis.plot import RunSeries, motion_figure, png_data, svg
from burnish.analysis.render import Camera
from burnish.analysis.scene import Scene
from burnish.analysis.shape import Shape

SCENE_FACES = 120_000
"""Most triangles of a scene that turns: about 1.5 MB in the file. A larger one is shown as a picture alone."""
SIMULATED = "All figures on this page are simulated: no real arm has moved."
SERIES_CAPTION = (
    "Contact force against its set value, angle between the tool and the surface normal, and speed along the surface "
    "against the commanded feed. Long runs are drawn by the extremes of each interval, so that no spike is lost."
)
MAP_CAPTION = (
    "The mould from above, and how much of the evaluated area lost how much. Removal is compared with the target; "
    "white marks on its scale: 50 %, 100 % and 150 %. Dashed: the border of the evaluated area."
)


@dataclass(frozen=True, kw_only=True)
class Event:
    """One intervention of the supervisor."""

    t: float
    """Time [s]."""
    cause: str
    """Which limit it was."""
    detail: str = ""
    """What was found and what was done."""


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """All that a report shows; parts that a run did not come to are left out of the page."""

    title: str
    """Headline, such as ``Polishing dome, 10 N at 20 mm/s``."""
    outcome: str
    """``done``, ``stopped by the supervisor: CAUSE`` or ``interrupted``."""
    metrics: Mapping[str, Scalar]
    """The figures of ``metrics.json``."""
    recipe: Mapping[str, Scalar]
    """What was asked for; names carry their units."""
    versions: Mapping[str, str]
    """Program or library to version."""
    seed: int
    """Number from which the errors of the run were drawn."""
    simulated: bool
    """Whether the figures are those of a simulator, which the page then says."""
    series: RunSeries | None = None
    """What happened over time."""
    removal: RemovalField | None = None
    """What was taken off the mould."""
    shapes: tuple[Shape, ...] = ()
    """The arm at work, in base axes."""
    camera: Camera | None = None
    """From where the picture is taken; by default the whole scene from the front right."""
    events: tuple[Event, ...] = field(default_factory=tuple)
    """Interventions of the supervisor."""


def write_report(report: RunReport, path: Path | str) -> None:
    """Write the report to ``path`` as one HTML file, whole or not at all.

    Raises:
        InputError: if the file cannot be written.
    """
    write_atomically(Path(path), report_html(report).encode())


def report_html(report: RunReport) -> str:
    """The page as text."""
    scene = _scene(report)
    return page(
        f"{report.title} – {report.outcome}",
        (
            _headline(report),
            _cards(report.metrics),
            _hero(scene),
            _surface(report.removal),
            _motion(report.series),
            _turning(scene),
            section("All figures", _metric_table(report.metrics)),
            section("Recipe", pairs(report.recipe)),
            section("Supervisor", _event_table(report.events)),
            section("Versions and seed", pairs({**report.versions, "seed": report.seed})),
        ),
    )


def _headline(report: RunReport) -> str:
    kind = "done" if report.outcome == "done" else "interrupted" if report.outcome == "interrupted" else "stopped"
    verdict = escape(report.outcome[:1].upper() + report.outcome[1:])
    note = f'<p class="note">{SIMULATED}</p>' if report.simulated else ""
    return f'<header><h1>{escape(report.title)}</h1><span class="verdict {kind}">{verdict}</span>{note}</header>'


def _cards(metrics: Mapping[str, Scalar]) -> str:
    names = [name for name in HEADLINE if _is_finite(metrics.get(name, math.nan))][:5]
    cards = [card(GLOSSARY[name].label, figure(metrics[name]), GLOSSARY[name].unit) for name in names]
    return f'<div class="cards">{"".join(cards)}</div>' if cards else ""


def _is_finite(value: Scalar) -> bool:
    return not isinstance(value, str) and math.isfinite(value)


def _scene(report: RunReport) -> Scene | None:
    if not any(len(shape.faces) for shape in report.shapes):
        return None
    scene = Scene.of(report.shapes)
    return Scene(shapes=scene.shapes, camera=report.camera or scene.camera)


def _hero(scene: Scene | None) -> str:
    if scene is None:
        return ""
    source = "data:image/png;base64," + base64.b64encode(scene.still()).decode("ascii")
    return f'<div class="hero">{picture(source, "The arm at work on the mould")}</div>'


def _turning(scene: Scene | None) -> str:
    if scene is None:
        return ""
    if sum(len(shape.faces) for shape in scene.shapes) > SCENE_FACES:
        return ""
    return f'<div class="screen">{section("In three dimensions", scene.interactive())}</div>'


def _surface(removal: RemovalField | None) -> str:
    if removal is None:
        return ""
    target = figure(1e6 * removal.target)
    return section(
        "Surface",
        '<div class="columns">'
        + picture(png_data(removal_map(removal)), "Mould from above, coloured by removal depth")
        + picture(png_data(coverage_map(removal)), "Mould from above, coloured by coverage class")
        + "</div>",
        drawing(svg(removal_histogram(removal), "removal"), f"{MAP_CAPTION} The target is {target} µm."),
    )


def _motion(series: RunSeries | None) -> str:
    if series is None or len(series.t) < 2:
        return ""
    return section("Force and motion", drawing(svg(motion_figure(series), "motion"), SERIES_CAPTION))


def _metric_table(metrics: Mapping[str, Scalar]) -> str:
    known = [name for name in GLOSSARY if name in metrics]
    rows = []
    for name in [*known, *sorted(set(metrics) - set(GLOSSARY))]:
        meaning = GLOSSARY.get(name, Meaning(name, "", ""))
        rows.append((meaning.label, f"{figure(metrics[name])} {meaning.unit}".strip(), meaning.text, name))
    return table(("figure", "value", "meaning", "name"), rows, numeric=1)


def _event_table(events: tuple[Event, ...]) -> str:
    if not events:
        return "<p>The supervisor never had to step in.</p>"
    return table(("time [s]", "cause", "detail"), ((f"{e.t:.3f}", e.cause, e.detail) for e in events))
