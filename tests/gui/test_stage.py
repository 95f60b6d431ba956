import pytest

from burnish.gui.stage import BUSY, LIVE, STEPS, WATCHER, Stage, ended, may_edit, may_stop, step


@pytest.mark.parametrize("stage", list(Stage))
def test_every_stage_says_what_comes_next(stage: Stage) -> None:
    assert STEPS[stage].label
    assert STEPS[stage].says.endswith(".")


@pytest.mark.parametrize("stage", list(Stage))
def test_a_watcher_may_do_nothing_and_is_told_why(stage: Stage) -> None:
    for offer in (step(stage, False)[1], may_stop(stage, False), may_edit(stage, False)):
        assert not offer.may
        assert offer.why == WATCHER


@pytest.mark.parametrize("stage", list(Stage))
def test_the_stop_is_there_exactly_while_something_moves(stage: Stage) -> None:
    assert may_stop(stage, True).may == (stage in LIVE)


@pytest.mark.parametrize("stage", BUSY)
def test_nothing_is_edited_while_a_plan_or_a_job_is_under_way(stage: Stage) -> None:
    assert not may_edit(stage, True).may


@pytest.mark.parametrize("stage", [Stage.EMPTY, Stage.ENDING])
def test_what_cannot_be_done_has_a_reason(stage: Stage) -> None:
    offer = step(stage, True)[1]
    assert not offer.may
    assert offer.why


@pytest.mark.parametrize(
    ("code", "paused", "report", "stage"),
    [
        (0, False, True, Stage.DONE),
        (130, True, True, Stage.PAUSED),
        (3, True, True, Stage.PAUSED),
        (-9, True, False, Stage.PAUSED),
        (2, False, False, Stage.FAILED),
        (-9, False, False, Stage.FAILED),
        (0, False, False, Stage.FAILED),
    ],
)
def test_how_a_job_ended_decides_what_comes_next(code: int, paused: bool, report: bool, stage: Stage) -> None:
    assert ended(code, paused=paused, report=report) is stage
