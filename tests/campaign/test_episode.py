"""An episode is the same whenever it is run, and its log is that of the plant."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from burnish.campaign import commanded, faults, measured, tasks
from burnish.campaign.draw import PAIRS, draw
from burnish.campaign.episode import run
from burnish.campaign.fault import INVALID, Fault
from burnish.campaign.judge import judge, load_limits
from burnish.sim.faulty import Garbage, Hang, Slow


def test_episode_is_drawn_from_its_seed_and_number_alone() -> None:
    first, again = draw(3, 17, nominal=False), draw(3, 17, nominal=False)
    assert [f.text for f in first.faults] == [f.text for f in again.faults]
    assert (first.duration, first.rate, first.task) == (again.duration, again.rate, again.task)
    other = draw(4, 17, nominal=False)
    assert (first.duration, [f.text for f in first.faults]) != (other.duration, [f.text for f in other.faults])


def test_log_of_an_episode_is_the_same_every_time() -> None:
    episode = draw(0, 0, nominal=False)
    first = run(episode)
    run(draw(0, 1, nominal=False))
    again = run(draw(0, 0, nominal=False))
    assert first.header == again.header
    for name, column in first.columns.items():
        assert_array_equal(column, again.columns[name], err_msg=name)


def test_every_kind_of_fault_and_every_task_is_drawn() -> None:
    drawn = [draw(0, number, nominal=False) for number in range(1500)]
    kinds = Counter(kind for episode in drawn for kind in episode.kinds)
    assert set(kinds) == {kind.__name__ for kind in faults.KINDS}
    assert min(kinds.values()) > 15
    assert {episode.task for episode in drawn} == set(tasks.TASKS)
    assert {episode.rate for episode in drawn} == {100.0, 1000.0}
    with_fault = [episode for episode in drawn if episode.kinds]
    pairs = sum(len(episode.kinds) == 2 for episode in with_fault)
    assert pairs / len(with_fault) == pytest.approx(PAIRS, abs=0.03)


def test_no_fault_is_drawn_for_nominal_work() -> None:
    drawn = [draw(0, number, nominal=True) for number in range(20)]
    assert not any(episode.faults for episode in drawn)
    assert {episode.task for episode in drawn} == {tasks.teleoperate, tasks.press_and_slide}


@pytest.mark.parametrize("task", tasks.TASKS, ids=lambda task: task.__name__)
def test_task_without_a_fault_is_done_without_a_stop(task: object) -> None:
    number = next(
        k for k in range(500) if draw(8, k, nominal=False).task is task and not draw(8, k, nominal=False).kinds
    )
    log = run(draw(8, number, nominal=False))
    verdict = judge(log.columns, log.header, load_limits())
    assert verdict.stopped_at is None, log.header["cause"]
    assert verdict.unsafe == 0
    assert log.header["trouble"] is None
    assert (verdict.peak_force > 2.0) == (task is tasks.press_and_slide)


def with_fault(fault: Fault, number: int = 2) -> dict[str, np.ndarray]:
    """The log of a task in the air with this fault."""
    episode = replace(draw(0, number, nominal=False), faults=(fault,), kinds=("made",), rate=100.0, duration=1.4)
    return run(replace(episode, task=tasks.track)).columns


def test_log_holds_what_was_sent_and_what_the_plant_did_not_what_was_told() -> None:
    lie = measured.encoder_jump(np.random.default_rng(1), 0.5, 0.01)
    columns = with_fault(lie)
    assert np.abs(np.diff(columns["q"], axis=0)).max() < 0.02, "the plant did not jump"
    assert columns["held"].any()
    assert np.isfinite(columns["tau"]).all()
    assert (np.abs(columns["tau"]) > 0.1).any()


def test_cycles_that_pass_while_the_controller_hangs_are_in_the_log() -> None:
    hung = measured.hang(np.random.default_rng(1), 0.5, 0.01)
    columns = with_fault(hung)
    missing = columns["sent"] == 0.0
    assert missing.sum() == hung.reading[0].lost
    assert_array_equal(columns["t"][missing] >= 0.5, True)


def test_law_that_raises_leaves_no_cycle_without_a_torque() -> None:
    columns = with_fault(commanded.exception(np.random.default_rng(1), 0.5, 0.01))
    assert columns["sent"].all()
    first = int(np.argmax(columns["t"] >= 0.5))
    assert columns["held"][first]


def test_bad_sample_that_was_lost_on_the_way_never_arrived() -> None:
    rng = np.random.default_rng(1)
    lost = replace(measured.lost_samples(rng, 0.3, 0.01), reading=(Slow(start=0.3, lost=4),))
    bad = Garbage(start=0.515, end=0.525, signal="q", index=0)
    fault = Fault(text="made", start=0.515, urgency=INVALID, reading=(bad,))
    episode = replace(draw(0, 2, nominal=False), kinds=("a", "b"), rate=100.0, duration=1.0, task=tasks.hold)
    log = run(replace(episode, faults=(lost, fault)))
    # Of five samples, one a hundredth of a second, the last one arrives.
    assert log.header["urgency"] is None
    assert not judge(log.columns, log.header, load_limits()).late


def test_reaction_is_counted_from_the_cycle_in_which_the_bad_sample_arrived() -> None:
    bad = Garbage(start=0.505, end=0.6, signal="q", index=0)
    fault = Fault(text="made", start=0.505, urgency=INVALID, reading=(bad,))
    lost = Fault(text="made", start=0.495, reading=(Hang(start=0.495, lost=3),))
    episode = replace(draw(0, 2, nominal=False), kinds=("a", "b"), rate=100.0, duration=1.0, task=tasks.hold)
    log = run(replace(episode, faults=(lost, fault)))
    verdict = judge(log.columns, log.header, load_limits())
    assert 0.505 < log.header["fault_at"] < 0.54
    assert (verdict.stopped_at, verdict.reaction) == (log.header["fault_at"], 0)


def test_judge_finds_a_supervisor_that_lets_everything_through(monkeypatch: pytest.MonkeyPatch) -> None:
    from burnish.runtime.supervisor import Supervisor

    monkeypatch.setattr(Supervisor, "filter", lambda self, arm, torque: torque)
    episode = draw(0, 2, nominal=False)
    wave = commanded.square_wave(np.random.default_rng(3), 0.3, 0.01)
    log = run(replace(episode, faults=(wave,), kinds=("square_wave",), task=tasks.hold, duration=1.0))
    assert judge(log.columns, log.header, load_limits()).over_rate > 5


def test_torque_that_is_no_number_is_in_the_log_though_the_driver_refuses_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from burnish.runtime.supervisor import Supervisor

    monkeypatch.setattr(Supervisor, "filter", lambda self, arm, torque: torque)
    episode = draw(0, 2, nominal=False)
    fault = commanded.not_finite(np.random.default_rng(3), 0.3, 0.01)
    log = run(replace(episode, faults=(fault,), kinds=("not_finite",), task=tasks.hold, duration=0.5))
    assert judge(log.columns, log.header, load_limits()).not_finite > 0
