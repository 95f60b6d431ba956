import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from gui_bench import Hand, bench, glance, gui

from burnish.gui import page as pages
from burnish.gui import words
from burnish.gui.page import Page
from burnish.gui.part import Part
from burnish.gui.planning import Preview
from burnish.gui.refusal import Refusal
from burnish.gui.stage import Stage
from burnish.runtime.machine import Mode


@pytest.fixture(scope="module")
def panel():
    with gui() as found:
        yield found


@pytest.fixture(scope="module")
def plate() -> Part:
    return Part.bundled("plate")


@pytest.fixture
def work(tmp_path: Path):
    with bench(tmp_path) as found:
        yield found


@pytest.fixture
def hand() -> Hand:
    return Hand()


@pytest.fixture
def page(panel, work, hand):
    panel.reset()
    return Page(panel, work, hand)


def settle(work, page, stage: Stage, **changed) -> None:
    for name, value in changed.items():
        setattr(work, name, value)
    work.stage = stage
    work.looked += 1
    page.refresh(work.glance())


def wait_for(condition) -> None:
    """Callbacks run in viser's threads."""
    for _ in range(200):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not come")


def test_a_new_page_asks_for_a_mould_and_can_do_nothing_else(page) -> None:
    assert page.step.disabled
    assert page.stop.disabled
    assert "Choose a mould" in page.headline.content


def test_the_stop_says_that_it_is_no_emergency_stop(panel, work, hand) -> None:
    panel.reset()
    Page(panel, work, hand)
    shown = [getattr(handle, "content", "") for handle in panel._gui_input_handle_from_uuid.values()]
    shown += [getattr(child, "content", "") for child in panel._container_handle_from_uuid["root"]._children.values()]
    assert any(words.NO_EMERGENCY_STOP in text for text in shown)


def test_choosing_a_mould_mounts_it(page, work) -> None:
    page.job.choice.value = "plate"
    wait_for(lambda: work.part is not None)
    assert work.part.name == "plate"
    assert "200 × 200" in work.part.says
    assert not page.step.disabled


def test_editing_the_force_changes_the_recipe_and_undo_brings_it_back(page, work) -> None:
    page.job.force.value = 12.0
    wait_for(lambda: work.edits.now.recipe.force == 12.0)
    wait_for(lambda: not page.job.undo.disabled)
    page.job.undo.value = True
    wait_for(lambda: work.edits.now.recipe.force == 10.0)
    wait_for(lambda: page.job.force.value == 10.0)


def test_showing_a_page_is_no_edit(page, work) -> None:
    settle(work, page, Stage.CHOSEN, edits=type(work.edits)(now=work.edits.now.with_feed(31.7).with_force(3.3)))
    assert page.job.feed.value == 31.7
    time.sleep(0.3)
    assert not work.edits.before


def test_the_button_leads_from_the_plan_to_the_job_to_the_pause(page, work, plate) -> None:
    work.mount(plate)
    settle(work, page, Stage.READY, preview=Preview())
    assert page.step.label == "Start polishing"
    page.step.value = True
    wait_for(lambda: work.stage is Stage.RUNNING)
    page.refresh(None)
    assert page.step.label == "Pause"
    assert not page.stop.disabled
    page.stop.value = True
    wait_for(lambda: work.jobs[0].asked == ["stop"])


def test_escape_stops_a_job_and_nothing_else(page, work, plate) -> None:
    work.mount(plate)
    settle(work, page, Stage.READY, preview=Preview())
    assert page.stop_key.disabled
    assert page.stop_key.hotkey == "escape"
    page.step.value = True
    wait_for(lambda: work.stage is Stage.RUNNING)
    page.refresh(None)
    assert not page.stop_key.disabled
    for callback in page.stop_key._impl.trigger_cb:
        callback(SimpleNamespace(client=None, client_id=None))
    assert work.jobs[0].asked == ["stop"]


def test_a_lesson_has_no_share_that_is_done(work) -> None:
    work.run(["teach"], work.new_folder("teach"), None)
    assert pages.says(work, glance(wall=time.monotonic())).endswith("3 of 9.")
    assert pages.progress(work, glance()) is None


def test_a_watcher_sees_controls_that_are_off_and_the_reason(page, work, hand, plate) -> None:
    work.mount(plate)
    hand.mine = False
    settle(work, page, Stage.READY, preview=Preview())
    assert page.step.disabled
    assert page.stop.disabled
    assert page.job.force.disabled
    assert page.job.upload.disabled
    assert "only watches" in page.headline.content
    assert page.step.hint


def test_a_watcher_who_presses_all_the_same_starts_nothing(page, work, hand, plate) -> None:
    work.mount(plate)
    settle(work, page, Stage.READY, preview=Preview())
    hand.mine = False
    page.step.value = True
    wait_for(lambda: "only watches" in page.trouble.content)
    assert not work.jobs
    assert work.stage is Stage.READY


def test_a_refusal_stands_on_the_page_with_what_helps(page, work) -> None:
    why = Refusal(why="Too fast.", remedy="Lower the feed.", where="Stroke 3", at=np.zeros(3))
    settle(work, page, Stage.REFUSED, preview=Preview(refusal=why))
    for part in ("Stroke 3", "Too fast.", "Lower the feed.", "red mark"):
        assert part in page.job.plan.content


def test_a_report_is_one_link_away_once_the_job_is_done(page, work, tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "report.html").write_text("<p>")
    settle(work, page, Stage.DONE, folder=tmp_path / "run", metrics={"force_rms_N": 0.31})
    assert page.report.visible
    assert 'href="/report/run"' in page.report.content
    assert "0.31 N" in page.job.result.content


def test_what_comes_from_a_file_is_never_html(page, work) -> None:
    settle(work, page, Stage.PAUSED, trouble="<script>alert(1)</script>")
    assert "<script>" not in page.trouble.content
    assert "&lt;script&gt;" in page.trouble.content


def test_a_held_arm_is_red_and_says_why(work) -> None:
    work.stage = Stage.RUNNING
    held = glance(mode=Mode.HOLD, cause="force 26 N")
    assert ("simulated arm: held by the supervisor", "red") in pages.chips(work, held, True)


def test_the_sentence_follows_the_job_from_its_plan_over_its_strokes_to_its_report(work) -> None:
    work.run(["polish"], work.new_folder("polish"), None)
    box = work.jobs[0].box
    box.tell("checking the path")
    assert "Nothing moves. Being done: checking the path" in pages.says(work, None)
    assert "polishes, stroke 3 of 9; 25 %" in pages.says(work, glance(wall=time.monotonic()))
    box.tell("writing the report")
    assert "Being done: writing the report" in pages.says(work, glance(wall=time.monotonic() - 5.0))


def test_progress_is_that_of_what_is_under_way(work) -> None:
    assert pages.progress(work, None) is None
    work.stage = Stage.RUNNING
    assert pages.progress(work, glance(done=0.4)) == 0.4
    work.stage, work.planner.share = Stage.PLANNING, 0.5
    assert pages.progress(work, None) == 0.5


def test_the_keys_of_a_lesson_are_on_exactly_while_they_mean_something(page, work, plate) -> None:
    work.mount(plate)
    work.run(["teach"], work.new_folder("teach"), None)
    work.jobs[0].box.post(glance(waits_for=("r", "space")))
    page.refresh(work.glance())
    on = {key for key, button in page.teach.keys.items() if not button.disabled}
    assert on == {"r", "space"}
    page.teach.keys["r"].value = True
    wait_for(lambda: work.jobs[0].box.pressed() == ["r"])
