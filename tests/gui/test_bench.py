import json
import time
from pathlib import Path

import pytest
from gui_bench import bench, block, glance

from burnish.errors import InputError, RecordingError
from burnish.gui.bench import metrics_of, resumable
from burnish.gui.part import Part
from burnish.gui.planning import Preview
from burnish.gui.refusal import Refusal
from burnish.gui.stage import Stage
from burnish.polish.journal import NAME, Journal, Mark
from burnish.polish.recipe_file import read_recipe
from burnish.runtime.machine import Mode


@pytest.fixture(scope="module")
def plate() -> Part:
    return Part.bundled("plate")


@pytest.fixture
def work(tmp_path: Path):
    with bench(tmp_path) as found:
        yield found


@pytest.fixture
def ready(work, plate):
    """A bench with a part and a plan that nobody had to make."""
    work.mount(plate)
    work.preview, work.stage = Preview(), Stage.READY
    return work


def journal(folder: Path, phase: str) -> None:
    mark = Mark(number=1, stroke=1, s=0.0, phase=phase, force=0.0, t=1.0, metres=0.0, joules=0.0)
    with Journal(folder / NAME, {}) as found:
        found.add(mark)


def test_an_edit_makes_the_plan_an_old_one(ready) -> None:
    ready.edit(lambda wish: wish.with_force(12.0))
    assert ready.stage is Stage.CHOSEN
    assert ready.preview is None
    with pytest.raises(InputError, match="plan the path first"):
        ready.start(None)


def test_an_edit_that_changes_nothing_keeps_the_plan(ready) -> None:
    ready.edit(lambda wish: wish.with_force(10.0))
    assert ready.stage is Stage.READY


def test_a_recipe_is_kept_under_its_name_and_comes_back_as_it_was(work) -> None:
    work.edit(lambda wish: wish.with_force(6.5).with_pattern("spiral"))
    row = work.keep_recipe(" gentle ")
    assert row.name == "gentle"
    assert read_recipe(work.library.file(row, "recipe")) == work.edits.now.recipe


def test_a_plan_is_made_of_what_is_mounted(work) -> None:
    with pytest.raises(InputError, match="no mould is chosen"):
        work.plan()


def test_a_job_is_the_command_line_with_the_recipe_beside_its_results(ready) -> None:
    ready.edits.now = ready.edits.now.with_force(7.0)
    ready.start(None)
    line = ready.jobs[0].line
    assert line[0] == "polish"
    assert read_recipe(Path(line[line.index("--recipe") + 1])).force == 7.0
    assert Path(line[line.index("--out") + 1]).is_relative_to(ready.library.root)


def test_nothing_is_edited_mounted_or_started_while_the_arm_is_at_work(ready, plate) -> None:
    ready.start(None)
    for forbidden in (lambda: ready.edit(lambda wish: wish.with_force(3.0)), lambda: ready.mount(plate), ready.plan,
                      ready.undo, lambda: ready.start(None), lambda: ready.resume(None)):  # fmt: skip
        with pytest.raises(InputError):
            forbidden()
    assert len(ready.jobs) == 1


@pytest.mark.parametrize("order", ["pause", "stop"])
def test_pause_and_stop_reach_the_job_once(ready, order: str) -> None:
    ready.start(None)
    getattr(ready, order)()
    assert ready.jobs[0].asked == [order]
    assert ready.stage is Stage.ENDING


def test_a_stop_with_no_job_does_nothing(ready) -> None:
    ready.stop()
    assert ready.stage is Stage.READY


def test_a_job_that_is_done_shows_what_it_reached(ready) -> None:
    ready.start(None)
    (ready.folder / "metrics.json").write_text(json.dumps({"force_rms_N": 0.3}))
    (ready.folder / "report.html").write_text("<p>")
    ready.look()
    assert ready.stage is Stage.RUNNING
    ready.jobs[0].outcome = 0
    ready.look()
    assert ready.stage is Stage.DONE
    assert ready.metrics == {"force_rms_N": 0.3}
    assert ready.report == ready.folder / "report.html"
    assert not ready.trouble


def test_a_repair_is_a_job_of_its_own_over_the_result_of_the_last_one(ready) -> None:
    with pytest.raises(InputError, match="polish first"):
        ready.repair(None)
    ready.start(None)
    first = ready.folder
    (first / "report.html").write_text("<p>")
    ready.jobs[0].outcome = 0
    ready.look()
    ready.repair(None)
    line = ready.jobs[1].line
    assert line[line.index("--repair") + 1] == str(first)
    assert line[line.index("--out") + 1] == str(ready.folder) != str(first)


def test_a_held_arm_says_why_and_can_be_gone_on_with(ready) -> None:
    ready.start(None)
    journal(ready.folder, "stopped")
    ready.jobs[0].box.post(glance(mode=Mode.HOLD, cause="force 26 N, limit 25 N"))
    ready.jobs[0].outcome = 3
    ready.look()
    assert ready.stage is Stage.PAUSED
    assert "force 26 N, limit 25 N" in ready.trouble
    ready.resume(None)
    assert ready.jobs[1].line[-2:] == ["--resume", str(ready.folder)]


def test_a_killed_job_can_be_gone_on_with_from_its_journal(ready) -> None:
    ready.start(None)
    journal(ready.folder, "pass")
    ready.jobs[0].outcome = -9
    ready.look()
    assert ready.stage is Stage.PAUSED
    assert "signal 9" in ready.trouble


def test_a_refused_job_says_what_the_verb_said(ready) -> None:
    ready.start(None)
    ready.jobs[0].outcome, ready.jobs[0].said = 2, "burnish: the mould is gone; choose another\n"
    ready.look()
    assert ready.stage is Stage.FAILED
    assert "the mould is gone; choose another" in ready.trouble


def test_a_finished_job_is_not_resumed(ready, tmp_path: Path) -> None:
    journal(tmp_path, "done")
    assert not resumable(tmp_path)
    with pytest.raises(RecordingError, match="start it anew"):
        ready.resume(None, tmp_path)


def test_figures_that_cannot_be_read_are_none(tmp_path: Path) -> None:
    assert metrics_of(tmp_path) == {}
    (tmp_path / "metrics.json").write_text("[1, 2")
    assert metrics_of(tmp_path) == {}


def test_a_plan_that_was_given_up_changes_nothing_when_it_comes(work, plate) -> None:
    work.mount(plate)
    work.plan()
    work.cancel_plan()
    work._planned(Preview(refusal=Refusal(why="late")))
    assert work.stage is Stage.CHOSEN
    assert work.preview is None


def test_a_plan_is_made_beside_the_caller_and_tells_how_far_it_is(work, tmp_path: Path) -> None:
    work.mount(Part.of_row(work.library, work.library.add_mould(block(tmp_path), unit="mm")))
    work.plan()
    assert work.stage is Stage.PLANNING
    stages = set()
    for _ in range(1200):
        stages.add(work.planner.stage)
        if work.stage is not Stage.PLANNING:
            break
        time.sleep(0.05)
    assert work.stage is Stage.READY
    assert len(stages - {""}) >= 2
    assert work.preview.length > 0.1
