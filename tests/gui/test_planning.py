import threading
from pathlib import Path

import numpy as np
import pytest
from gui_bench import block

from burnish.gui.planning import CRASHED, STAGES, Planner, Preview, preview
from burnish.gui.wish import Wish
from burnish.polish.recipe import PRESTON, Recipe


def test_a_plan_is_told_stage_by_stage(tmp_path: Path) -> None:
    told: list[int] = []
    found = preview(str(block(tmp_path)), "mm", Recipe(), told.append)
    assert told == list(range(len(STAGES)))
    assert found.refusal is None
    assert found.length == pytest.approx(sum(stroke.length for stroke in found.strokes))
    # Parallel tracks leave k F / step, whatever the pressure looks like; 2.5 mm is the step of 10 N on the felt.
    assert found.target == pytest.approx(PRESTON * 10.0 / 2.5e-3, rel=0.1)


def test_a_plan_that_is_too_fast_is_refused_with_its_place_and_its_strokes() -> None:
    found = preview("wave", "auto", Wish().with_feed(80.0).recipe, lambda stage: None)
    assert found.refusal is not None
    assert found.strokes
    assert found.refusal.at is not None
    near = min(float(np.linalg.norm(stroke.points - found.refusal.at, axis=1).min()) for stroke in found.strokes)
    assert near < 1e-4
    assert "mm/s" in found.refusal.remedy


def test_a_mould_that_is_not_there_is_refused_in_words() -> None:
    found = preview("no such.stl", "auto", Recipe(), lambda stage: None)
    assert found.refusal is not None
    assert found.strokes == ()


def test_a_planner_that_is_killed_is_a_refusal_and_no_silence() -> None:
    planner, came, found = Planner(), threading.Event(), []

    def done(result: Preview) -> None:
        found.append(result)
        came.set()

    planner.start("wave", "auto", Recipe(), done)
    assert planner._process is not None
    planner._process.kill()
    assert came.wait(30.0)
    assert found[0].refusal.why.startswith(CRASHED)
    assert not planner.busy


def test_a_plan_that_is_given_up_never_answers() -> None:
    planner, came = Planner(), threading.Event()
    planner.start("wave", "auto", Recipe(), lambda result: came.set())
    process = planner._process
    planner.cancel()
    assert not planner.busy
    assert process is not None
    assert not process.is_alive()
    assert not came.wait(0.5)
