"""The report for a part's customer."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from burnish.analysis.part import PartReport, part_html, write_part
from burnish.analysis.report import RunReport
from burnish.finish.roughness import Roughness

HOSTILE = "<script>alert('x')</script>\"&"
METRICS = {"coverage_pct": 99.1, "overpolished_pct": 0.4, "removal_cv_pct": 9.0, "force_rms_N": 0.21}


def report(**changed: object) -> PartReport:
    metrics = changed.pop("metrics", METRICS)
    run = RunReport(
        title="t", outcome="done", metrics=metrics, recipe={}, versions={"burnish": "1"}, seed=4, simulated=True
    )
    whole = PartReport(
        part="dome",
        part_sha256="ab" * 32,
        outcome="done",
        metrics=metrics,
        passes=[("1", "5.12", "10.00", "0.21", "10.7")],
        recipe={"contact force [N]": 10.0},
        trace={"burnish": "1", "limits": "c0ffee", "seed": "4"},
        remarks=("the abrasive has done 5.12 m.",),
        untold="",
        target_um=0.079,
        run=run,
    )
    return replace(whole, **changed)


def shown(page: str) -> str:
    text = re.sub(r"<style>.*?</style>", "", page, flags=re.S)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


def test_page_says_what_was_reached_and_with_what() -> None:
    text = shown(part_html(report()))
    for words in ("99.1", "at least 98 %", "abab", "c0ffee", "polished by", "Pass", "5.12", "simulated"):
        assert words.lower() in text.lower(), words


def test_page_of_a_repair_says_so_and_what_was_there_before() -> None:
    assert "repair" not in shown(part_html(report())).lower()
    metrics = METRICS | {"coverage_before_pct": 31.9, "removal_cv_before_pct": 134.0}
    text = shown(part_html(report(mends="runs/old", metrics=metrics)))
    for words in ("after a repair", "before the repair", "31.9", "134"):
        assert words in text, words


def test_estimated_roughness_is_shown_with_its_interval_and_as_not_measured() -> None:
    assert "oughness" not in shown(part_html(report()))
    text = shown(part_html(report(roughness=Roughness(value=2.5e-7, low=1.1e-7, high=6.2e-7))))
    for words in ("0.25", "0.11 to 0.62", "95 %", "was not measured"):
        assert words in text, words


def test_what_was_not_reached_is_said_in_words() -> None:
    text = shown(
        part_html(
            report(metrics=METRICS | {"coverage_pct": 91.0}, outcome="interrupted", untold="shift along x (±1.5 mm)")
        )
    )
    assert "9 % of the surface got less than half of the wanted removal" in text
    assert "did not come to its end: interrupted" in text
    assert "could not tell how the part lay in: shift along x" in text
    assert "1.5 times" not in shown(part_html(report()))


def test_page_asks_for_nothing_and_escapes_all() -> None:
    page = part_html(report(part=HOSTILE, remarks=(HOSTILE,), recipe={HOSTILE: HOSTILE}, outcome=HOSTILE))
    assert "<script" not in page
    assert not re.search(r"(?:src|href)=\"(?!data:)", page)


def test_page_prints_on_a4(tmp_path: Path) -> None:
    write_part(report(), tmp_path / "part.html")
    page = (tmp_path / "part.html").read_text()
    assert "@page{size:A4" in page
    assert "@media print" in page


def test_run_without_figures_says_so() -> None:
    text = shown(part_html(report(metrics={}, outcome="stopped: nothing was touched")))
    assert "did not polish long enough for any figure" in text
