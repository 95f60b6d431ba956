import time
from pathlib import Path

import numpy as np
import pytest
from gui_bench import Hand, bench, glance, gui

from burnish.cli import Parser
from burnish.commands.teach_options import add_teach
from burnish.gui.page import Page
from burnish.gui.part import Part
from burnish.gui.stage import Stage
from burnish.gui.teach import DEVICES, KEYS, MOVES, twist


@pytest.fixture(scope="module")
def panel():
    with gui() as found:
        yield found


@pytest.fixture
def work(tmp_path: Path):
    with bench(tmp_path) as found:
        yield found


@pytest.fixture
def page(panel, work) -> Page:
    panel.reset()
    return Page(panel, work, Hand())


def wait_for(condition) -> None:
    for _ in range(200):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not come")


@pytest.mark.parametrize("name", list(DEVICES))
def test_a_lesson_is_a_line_that_the_command_line_takes(page, work, name: str) -> None:
    work.mount(Part.bundled("plate"))
    page.teach.device.value = name
    page.teach.start.value = True
    wait_for(lambda: work.stage is Stage.RUNNING)
    parser = Parser()
    add_teach(parser)
    options = parser.parse_args(work.jobs[0].line[1:])
    assert options.device == DEVICES[name]
    assert options.mould == "plate"
    assert Path(options.out).is_relative_to(work.library.root)


def test_without_a_mould_there_is_no_lesson_and_without_a_lesson_no_replay(page) -> None:
    assert page.teach.start.disabled
    assert page.teach.replay.disabled
    assert page.teach.start.hint
    assert page.teach.replay.hint


def test_the_tool_is_moved_only_in_a_lesson_that_the_page_leads(page, work) -> None:
    assert all(button.disabled for button in page.teach.moves.values())
    work.mount(Part.bundled("plate"))
    work.run(["teach"], work.new_folder("teach"), None)
    work.jobs[0].box.post(glance(waits_for=("e",)))
    page.refresh(work.glance())
    assert not any(button.disabled for button in page.teach.moves.values())
    work.jog(twist(2, -1.0, 40.0))
    assert work.jobs[0].box.jogged == pytest.approx([0.0, 0.0, -0.4, 0.0, 0.0, 0.0])


def test_a_jog_goes_along_one_axis_and_is_never_more_than_the_whole_speed() -> None:
    found = np.array([twist(axis, sign, 100.0) for axis, sign in MOVES.values()])
    assert (np.abs(found).sum(axis=1) == 1.0).all()
    assert (found.sum(axis=0) == 0.0).all()


def test_a_jog_after_the_lesson_has_no_arm_to_move(work) -> None:
    work.jog(twist(0, 1.0, 40.0))
    assert work.jobs == []


def test_every_key_of_a_session_has_a_button() -> None:
    from burnish.commands.seat import OUTSIDE

    assert set(OUTSIDE) == set(KEYS)
