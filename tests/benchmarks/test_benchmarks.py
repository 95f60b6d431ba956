"""The benchmarks as far as they can be tested in seconds: their options, and how a campaign judges."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from burnish.core import State
from burnish.model.model import Model
from burnish.paths.stroke import Stroke
from burnish.rotation import exp

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
SCRIPTS = ("campaign", "faults", "step", "thesis_baseline")


@pytest.fixture
def scripts(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Imports a benchmark as its own command line would."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    before = set(sys.modules)

    def load(name: str) -> ModuleType:
        return __import__(name)

    yield load
    for name in (*SCRIPTS, "common", "cases", "finishing_run"):
        if name not in before:
            sys.modules.pop(name, None)


@pytest.mark.parametrize("name", SCRIPTS)
def test_help_names_the_options_and_the_defaults(name: str) -> None:
    run = subprocess.run(
        [sys.executable, str(BENCHMARKS / f"{name}.py"), "--help"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert "--out" in run.stdout
    assert "default" in run.stdout


GOOD: dict[str, Any] = {
    "force_rms_N": 0.3,
    "force_p99_N": 1.2,
    "contact_lost_pct": 0.0,
    "touch_peak_N": 2.0,
    "tilt_rms_deg": 0.5,
    "tilt_max_deg": 1.5,
    "coverage_pct": 99.0,
    "overpolished_pct": 1.0,
    "exit_status": 0,
}


def rows_by_figure(rows: list[Any]) -> dict[str, Any]:
    return {row.figure: row for row in rows}


def test_a_case_whose_seeds_are_all_good_meets_every_goal(scripts: Any) -> None:
    cases = scripts("cases")
    rows = cases.judge(cases.CASES[0], {1: GOOD, 2: GOOD})
    assert {row.verdict for row in rows} == {"met"}


def test_the_worst_seed_decides_the_largest_where_less_is_better(scripts: Any) -> None:
    cases = scripts("cases")
    row = rows_by_figure(cases.judge(cases.CASES[0], {1: GOOD, 2: GOOD | {"force_rms_N": 0.51}, 3: GOOD}))
    assert (row["force RMS [N]"].worst, row["force RMS [N]"].seed, row["force RMS [N]"].verdict) == (0.51, 2, "missed")
    assert row["force p99 [N]"].verdict == "met"


def test_the_worst_seed_decides_the_smallest_where_more_is_better(scripts: Any) -> None:
    cases = scripts("cases")
    row = rows_by_figure(cases.judge(cases.CASES[0], {1: GOOD | {"coverage_pct": 97.9}, 2: GOOD}))
    assert (row["coverage [%]"].worst, row["coverage [%]"].seed, row["coverage [%]"].verdict) == (97.9, 1, "missed")


def test_a_value_at_its_limit_meets_the_goal(scripts: Any) -> None:
    cases = scripts("cases")
    at_limit = GOOD | {"force_rms_N": 0.5, "coverage_pct": 98.0}
    assert {row.verdict for row in cases.judge(cases.CASES[0], {1: at_limit})} == {"met"}


def test_a_figure_that_one_run_lacks_is_missed(scripts: Any) -> None:
    cases = scripts("cases")
    without = {name: value for name, value in GOOD.items() if name != "tilt_rms_deg"}
    row = rows_by_figure(cases.judge(cases.CASES[0], {1: GOOD, 2: without}))["tilt RMS [deg]"]
    assert (row.worst, row.verdict) == (None, "missed")


def test_a_run_that_failed_misses_all_goals_of_its_case(scripts: Any) -> None:
    cases = scripts("cases")
    assert {row.verdict for row in cases.judge(cases.CASES[0], {1: GOOD, 2: None})} == {"missed"}


def test_a_run_that_the_supervisor_stopped_is_counted(scripts: Any) -> None:
    cases = scripts("cases")
    row = rows_by_figure(cases.judge(cases.CASES[0], {1: GOOD, 2: GOOD | {"exit_status": 3}}))
    assert (row["runs stopped or failed"].seed, row["runs stopped or failed"].verdict) == (2, "missed")


def test_a_figure_without_goal_is_reported_and_never_missed(scripts: Any) -> None:
    cases = scripts("cases")
    goal = cases.Goal(name="force_rms_N", label="force RMS [N]")
    case = cases.Case(name="any", mould="plate", arm="ideal", goals=(goal,))
    row = cases.judge(case, {1: GOOD | {"force_rms_N": 1e3}})[0]
    assert (row.worst, row.goal, row.verdict) == (1e3, "-", "-")


def test_preston_deviation_counts_on_both_sides(scripts: Any) -> None:
    campaign, cases = scripts("campaign"), scripts("cases")
    case = cases.Case(name="any", mould="plate", arm="honest", goals=(cases.DEVIATION,))
    # The depths are 3 % too small and 1 % too large; the goal is 2 %.
    runs = {seed: campaign.with_deviation({"removal_mean_um": um}, 1e-6) for seed, um in ((1, 0.97), (2, 1.01))}
    row = cases.judge(case, runs)[0]
    assert row.worst == pytest.approx(-3.0)
    assert (row.seed, row.verdict) == (1, "missed")


def test_cases_have_folders_of_their_own(scripts: Any) -> None:
    cases = scripts("cases")
    assert len({case.slug for case in cases.CASES}) == len(cases.CASES)


def test_a_run_that_is_done_is_not_run_again(scripts: Any, tmp_path: Path) -> None:
    campaign, cases = scripts("campaign"), scripts("cases")
    case = cases.CASES[0]
    folder = tmp_path / case.slug / "seed-4"
    folder.mkdir(parents=True)
    (folder / "metrics.json").write_text(json.dumps(GOOD))
    before = list(folder.iterdir())
    assert campaign.Campaign(tmp_path, 1, False).run(case, 4) == GOOD
    assert list(folder.iterdir()) == before


def test_the_page_shows_every_row_and_counts_what_was_missed(scripts: Any) -> None:
    campaign, cases = scripts("campaign"), scripts("cases")
    rows = cases.judge(cases.CASES[0], {1: GOOD | {"tilt_max_deg": 4.0}})
    page = campaign.markdown(rows, {"date": "2000-01-01", "cores": 2, "source": "0"}, [1], "")
    assert page.count("dome, honest") == len(rows)
    assert f"1 of {len(rows)} goals missed" in page


def test_pieces_are_two_neighbouring_lines_with_the_turn_between(scripts: Any) -> None:
    common = scripts("common")
    x = np.linspace(0.0, 0.1, 201)
    lines = [np.column_stack((x if k % 2 == 0 else x[::-1], np.full(201, 0.002 * k), np.zeros(201))) for k in range(6)]
    points = np.concatenate(lines)
    level = np.ones(len(points))
    stroke = Stroke(points=points, normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)), feed=level, force=level)
    pieces = common.pieces_of([stroke], 2)
    assert [np.unique(piece.points[:, 1]).size for piece in pieces] == [2, 2]
    assert common.line_distance([stroke]) == pytest.approx(0.002)


def test_the_baselines_spring_presses_with_the_set_force_where_the_tool_is_on_its_path(scripts: Any) -> None:
    baseline = scripts("thesis_baseline")
    model = Model.jaco2()
    arm = model.at(State(t=0.0, q=np.array([4.53, 3.25, 1.37, 5.85, 1.49, 1.32]), dq=np.zeros(6)))
    reference = baseline.ToolReference(
        p=arm.p, R=arm.R, v=np.zeros(6), a=np.zeros(6), normal=np.array([0.0, 0.0, 1.0]), force=10.0
    )
    push = np.linalg.solve(arm.J.T, baseline.SunkImpedance().torque(arm, reference) - arm.g)
    np.testing.assert_allclose(push, [0.0, 0.0, -10.0, 0.0, 0.0, 0.0], atol=1e-9)


def test_the_baseline_turns_the_tool_towards_its_reference(scripts: Any) -> None:
    baseline = scripts("thesis_baseline")
    model = Model.jaco2()
    arm = model.at(State(t=0.0, q=np.array([4.53, 3.25, 1.37, 5.85, 1.49, 1.32]), dq=np.zeros(6)))
    turn = np.array([0.1, -0.2, 0.05])
    reference = baseline.ToolReference(p=arm.p, R=exp(turn) @ arm.R, v=np.zeros(6), a=np.zeros(6))
    push = np.linalg.solve(arm.J.T, baseline.SunkImpedance().torque(arm, reference) - arm.g)
    # K_o sin(θ/2) u by hand.
    angle = np.linalg.norm(turn)
    np.testing.assert_allclose(push[3:], 9.5 * np.sin(angle / 2.0) * turn / angle, atol=1e-9)


def test_a_baseline_that_ended_early_does_not_count_in_the_ratio(scripts: Any) -> None:
    baseline = scripts("thesis_baseline")

    def run(rms: float, supervisor: str | None = None) -> dict[str, Any]:
        return {"seed": 1, "force_rms_N": rms, "supervisor": supervisor, "failure": None}

    ratio = baseline.worst_ratio([run(0.5), run(0.25)], [run(2.0), run(10.0, "the tool force reached 275.1 N")])
    assert ratio == (4.0, 1)
    assert baseline.worst_ratio([run(0.5)], [run(2.0, "stopped")]) == (None, 0)


def test_a_tool_beside_its_line_is_not_on_the_next_one(scripts: Any) -> None:
    run = scripts("finishing_run")
    stroke = run.patch(0.02)
    # As seen: 1.5 mm beside its own line it is nearer to the next one, which it has not worked yet.
    beside = stroke.points[:, :2] + np.column_stack([np.zeros(len(stroke.arc)), np.full(len(stroke.arc), 1.5e-3)])
    straight = np.abs(stroke.points[:, 0]) < 0.9 * run.HALF
    assert np.abs(run.followed(stroke, beside, 0.0) - stroke.arc)[straight].max() < 2.5e-3
    half = len(stroke.arc) // 2
    touches = np.array([[0.0, 0.2], [0.1, 0.1]])
    later = run.followed(stroke, np.concatenate([touches, stroke.points[half:, :2]]), float(stroke.arc[half]))
    assert np.allclose(later[2:], stroke.arc[half:])
