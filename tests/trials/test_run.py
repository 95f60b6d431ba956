"""A trial on the simulated arm: it runs to its end, or ends early and says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from burnish.control import Impedance, OperationalSpace
from burnish.core import Array
from burnish.experiments.jumps import Jumps, blog_targets
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.trajectory import HoldPose
from burnish.trials.experiment import Trial, nominal
from burnish.trials.figures import figures
from burnish.trials.run import run


def trial(arm: Arm, law: object) -> Trial:
    return Trial(name="t", law=law, source=HoldPose(), duration=0.3, arm=arm, model=nominal(arm))  # type: ignore[arg-type]


def test_a_trial_runs_at_its_rate_to_its_end() -> None:
    shares: list[float] = []
    record = run(replace(trial(arms.ideal(0), OperationalSpace.at_frequency(15.0)), rate=200.0), shares.append)
    assert record.stopped is None
    assert len(record.t) == 60
    assert record.position_error.max() < 1e-6
    assert shares[-1] == pytest.approx(1.0, abs=0.02)
    assert min(record.step_us) > 0.0


def test_a_law_that_oscillates_is_stopped_with_a_reason() -> None:
    # D dt = 0.03 N·m·s/rad · 1 ms on 0.001 kg·m² would do; 3 is beyond 2 I / dt (thesis B's table 5.4).
    record = run(replace(trial(arms.ideal(0), Impedance(stiffness=(200.0, 80.0), damping=(24.0, 8.0))), duration=1.0))
    assert record.stopped is not None
    assert "raced" in record.stopped
    assert record.t[-1] < 0.9


def test_a_law_without_numbers_is_stopped() -> None:
    class Broken(OperationalSpace):
        def torque(self, arm: object, reference: object) -> Array:  # type: ignore[override]
            return np.full(6, np.nan)

    record = run(trial(arms.ideal(0), Broken.at_frequency(15.0)))
    assert record.stopped == "the law gave a torque that is not finite"
    assert figures(record).position_rmse_mm < 1e-3


def test_a_push_moves_the_tool() -> None:
    pushed = replace(trial(arms.ideal(0), OperationalSpace.at_frequency(8.0)), push=lambda t: np.eye(6)[0] * 5.0)
    assert run(pushed).position_error.max() > 1e-3


def test_jumps_hold_each_pose_for_its_time() -> None:
    poses = blog_targets(3)
    source = Jumps(poses=poses, every=0.1)
    record = run(replace(trial(arms.ideal(0), OperationalSpace.at_frequency(15.0)), source=source))
    for k, (p, _) in enumerate(poses):
        assert np.allclose(record.p_d[100 * k + 50], p)


def test_blog_targets_leave_alone_what_they_shall() -> None:
    still, turning = blog_targets(4, turn=False), blog_targets(4, shift=False)
    assert all(np.allclose(R, still[0][1]) for _, R in still)
    assert all(np.allclose(p, turning[0][0]) for p, _ in turning)
    angles = [np.arccos((np.trace(R @ still[0][1].T) - 1.0) / 2.0) for _, R in turning]
    assert 3.0 <= np.degrees(min(angles)) <= np.degrees(max(angles)) <= 6.0
