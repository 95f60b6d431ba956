"""The report of a part for its customer: one HTML file that prints on A4 and asks for nothing from outside.

In the customer's words: which part, what was asked for, what was reached, what was not, and with what it was made, so
that it can be traced. The run's own report, beside it, is for the people at the arm.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from burnish.analysis.atomic import write_atomically
from burnish.analysis.glossary import figure
from burnish.analysis.metrics import Scalar
from burnish.analysis.mould_map import coverage_map, removal_map
from burnish.analysis.page import page, pairs, picture, section, table
from burnish.analysis.plot import png_data
from burnish.analysis.report import SIMULATED, RunReport
from burnish.analysis.scene import Scene
from burnish.finish.roughness import Roughness

COVERED, OVER, SPREAD, HELD = 98.0, 3.0, 12.0, 0.5
"""Coverage at least [%], over-polished at most [%], removal's spread at most [%], force error at most [N RMS]."""


@dataclass(frozen=True, kw_only=True)
class PartReport:
    """All that the page shows."""

    part: str
    """Name of the mould."""
    part_sha256: str
    """Fingerprint of its geometry."""
    outcome: str
    """How the run ended, in words."""
    metrics: Mapping[str, Scalar]
    """The figures of ``metrics.json``."""
    passes: Sequence[Sequence[str]]
    """A row a pass: number, path [m], mean force [N], force error [N], stiffness of the contact [kN/m]."""
    recipe: Mapping[str, Scalar]
    """What was asked for; names carry their units."""
    trace: Mapping[str, str]
    """Versions, fingerprints and seed."""
    remarks: Sequence[str]
    """Sentences for the reader."""
    untold: str
    """What the touches could not tell of where the part stood; empty if nothing."""
    target_um: float
    """Wanted removal [µm]."""
    run: RunReport
    """The run: its pictures and whether it was simulated."""
    roughness: Roughness | None = None
    """What the grit is believed to have left; None where nothing is known of it."""
    mends: str = ""
    """Folder of the job that this one repaired; empty for one of its own."""


def write_part(report: PartReport, path: Path) -> None:
    """Write the page, whole or not at all.

    Raises:
        InputError: if the file cannot be written.
    """
    write_atomically(path, part_html(report).encode())


def part_html(report: PartReport) -> str:
    """The page as text."""
    return page(
        f"{_kind(report)} – {report.part}",
        (
            f"<style>{PRINT}</style>",
            _head(report),
            section("The part", pairs({"part": report.part, "fingerprint of its geometry": report.part_sha256[:32]})),
            section("Asked for", pairs(report.recipe)),
            section("Reached", _reached(report)),
            section("Not reached", _missed(report)),
            _maps(report),
            section("Passes of the last run", table(PASS_HEAD, report.passes)),
            section("Remarks", _sentences([text[:1].upper() + text[1:] for text in report.remarks])),
            section("Made with", pairs(report.trace)),
            section("Signed", SIGNED),
        ),
    )


def _kind(report: PartReport) -> str:
    """What the page is of."""
    return "Part report, after a repair" if report.mends else "Part report"


def _head(report: PartReport) -> str:
    done = report.outcome == "done"
    verdict = escape(report.outcome[:1].upper() + report.outcome[1:])
    note = f'<p class="note">{SIMULATED}</p>' if report.run.simulated else ""
    return (
        f'<header><h1>{_kind(report)}: {escape(report.part)}</h1><span class="verdict {"done" if done else "stopped"}">'
        f"{verdict}</span>{note}</header>"
    )


def _goals(report: PartReport) -> list[tuple[str, float, str, bool, str]]:
    """What, found, limit in words, whether it is met, and what it means where it is not."""
    found = []
    for name, label, unit, limit, low, missing in (
        ("coverage_pct", "Surface that was polished", "%", COVERED, True, "got less than half of the wanted removal"),
        ("overpolished_pct", "Surface polished too much", "%", OVER, False, "lost 1.5 times the wanted depth or more"),
        ("removal_cv_pct", "Spread of the removal", "%", SPREAD, False, "is less even than agreed"),
        ("force_rms_N", "Force held to within", "N", HELD, False, "was pressed less evenly than agreed"),
    ):  # fmt: skip
        value = report.metrics.get(name)
        if isinstance(value, int | float):
            met = bool(value >= limit if low else value <= limit)
            sign = "at least" if low else "at most"
            found.append((label, float(value), f"{unit}, {sign} {limit:g} {unit}", met, missing))
    return found


def _reached(report: PartReport) -> str:
    rows = [
        (label, figure(value), limit.split(",")[0], limit.split(", ")[1], "yes" if met else "no")
        for label, value, limit, met, _ in _goals(report)
    ]
    mean = report.metrics.get("removal_mean_um")
    if isinstance(mean, int | float):
        rows.append(("Removed on the mean", figure(float(mean)), "µm", f"{figure(report.target_um)} µm wanted", ""))
    for name, label in (
        ("coverage_before_pct", "Polished before the repair"),
        ("removal_cv_before_pct", "Spread before"),
    ):
        if isinstance(value := report.metrics.get(name), int | float):
            rows.append((label, figure(float(value)), "%", "", ""))
    if report.roughness is not None:
        low, value, high = (1e6 * x for x in (report.roughness.low, report.roughness.value, report.roughness.high))
        rows.append(
            ("Roughness Ra, estimated", figure(value), "µm", f"{figure(low)} to {figure(high)} µm with 95 %", "")
        )
    return table(("what", "found", "unit", "wanted", "met"), rows, numeric=1)


def _missed(report: PartReport) -> str:
    said = []
    if report.outcome != "done":
        said.append(f"The job did not come to its end: {report.outcome}. What is left can be done later.")
    for label, value, limit, met, missing in _goals(report):
        if not met:
            unit = limit.split(",")[0]
            where = {
                "Surface that was polished": f"{figure(100.0 - value)} % of the surface {missing}.",
                "Surface polished too much": f"{figure(value)} % of the surface {missing}.",
            }
            said.append(where.get(label, f"The part {missing}: {label.lower()} is {figure(value)} {unit}."))
    if report.untold:
        said.append(f"The touches could not tell how the part lay in: {report.untold}. There it is taken as planned.")
    if not _goals(report):
        said.append("The tool did not polish long enough for any figure.")
    said.append("The edge band of the part, and what the tip does not reach, are not part of these figures.")
    said.append("Depths follow from an assumed Preston coefficient; percentages do not depend on it.")
    if report.roughness is not None:
        said.append("The roughness was not measured: it is estimated from the depth, with the constants of the recipe.")
    return _sentences(said)


def _maps(report: PartReport) -> str:
    parts = []
    removal = report.run.removal
    if removal is not None:
        parts += [
            picture(png_data(removal_map(removal)), "Part from above, coloured by removal depth", "Depth removed."),
            picture(png_data(coverage_map(removal)), "Part from above, coloured by coverage", "What was covered."),
        ]
    if any(len(shape.faces) for shape in report.run.shapes):
        scene = Scene.of(report.run.shapes)
        still = Scene(shapes=scene.shapes, camera=report.run.camera or scene.camera).still()
        source = "data:image/png;base64," + base64.b64encode(still).decode("ascii")
        parts.append(picture(source, "The arm at work on the part", "The arm at work."))
    return section("Pictures", f'<div class="columns">{"".join(parts)}</div>') if parts else ""


def _sentences(sentences: Sequence[str]) -> str:
    return "".join(f"<p>{escape(sentence)}</p>" for sentence in sentences)


PASS_HEAD = ("pass", "path [m]", "mean force [N]", "force error [N RMS]", "stiffness of the contact [kN/m]")
SIGNED = (
    '<div class="sign"><div>order or part number<span></span></div><div>polished by<span></span></div>'
    "<div>checked by<span></span></div><div>date<span></span></div></div>"
)
PRINT = """
@page{size:A4;margin:14mm}
.sign{display:grid;grid-template-columns:1fr 1fr;gap:1.6rem 2rem;color:var(--soft);font-size:.9rem}
.sign span{display:block;height:1.8rem;border-bottom:1px solid var(--ink)}
section p{margin:.3rem 0}
@media print{
body{background:#fff;font-size:10pt}
main{max-width:none;padding:0}
section{border:0;border-top:1px solid var(--line);border-radius:0;padding:.5rem 0;margin:.4rem 0;break-inside:avoid}
h2{break-after:avoid}
.columns{grid-template-columns:1fr 1fr}
.verdict{border:1px solid var(--line)}
*{-webkit-print-color-adjust:exact;print-color-adjust:exact}
}
"""
