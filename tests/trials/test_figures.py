"""The figures of a trial, on records whose figures are known by hand."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from burnish.core import Array
from burnish.model.model import Model
from burnish.trials.figures import figures, roughness, settling
from burnish.trials.record import Record

N, DT = 4000, 1e-3
TIME = DT * np.arange(N)


def record(
    *, p: Array, p_d: Array, angle: Array, angle_d: Array | None = None, tau: Array | None = None, **columns: Array
) -> Record:
    """A record of a motion along x and about z; arrays (N,)."""
    angle_d = np.zeros(len(p)) if angle_d is None else angle_d
    x, z = np.eye(3)[0], np.eye(3)[2]
    tau = np.zeros((len(p), 6)) if tau is None else tau
    return Record(
        model=Model.jaco2(),
        t=list(DT * np.arange(len(p))),
        q=list(np.zeros((len(p), 6))),
        p=list(np.outer(p, x)),
        p_d=list(np.outer(p_d, x)),
        turn=list(np.outer(angle_d - angle, z)),
        turn_d=list(np.outer(angle_d, z)),
        joint_error=list(columns.get("joint_error", np.full((len(p), 6), np.nan))),
        tau=list(tau),
        step_us=list(columns.get("step_us", np.full(len(p), 20.0))),
    )


def decaying(step: float, rate: float, start: float = 1.0) -> tuple[Array, Array]:
    """A step of the reference at ``start``, and what follows it exponentially."""
    after = start <= TIME
    return np.where(after, step * (1.0 - np.exp(-rate * (TIME - start))), 0.0), np.where(after, step, 0.0)


def test_rmse_of_a_constant_offset_is_the_offset() -> None:
    of = figures(record(p=np.zeros(N), p_d=np.full(N, 0.002), angle=np.full(N, np.radians(3.0))))
    assert of.position_rmse_mm == pytest.approx(2.0)
    assert of.orientation_rmse_deg == pytest.approx(3.0)
    assert of.joint_rmse_mrad is None


def test_joint_rmse_is_that_of_all_joints() -> None:
    error = np.zeros((N, 6))
    error[:, 0] = 0.006
    of = figures(record(p=np.zeros(N), p_d=np.zeros(N), angle=np.zeros(N), joint_error=error))
    assert of.joint_rmse_mrad == pytest.approx(6.0 / np.sqrt(6.0))


def test_steady_state_is_the_last_second_only() -> None:
    p = np.where(TIME[-1] - 1.0 - DT / 2 < TIME, 0.001, 0.5)
    assert figures(record(p=p, p_d=np.zeros(N), angle=np.zeros(N))).position_steady_mm == pytest.approx(1.0)


def test_settling_of_a_decay_ends_where_two_percent_are_left() -> None:
    p, p_d = decaying(0.2, rate=5.0)
    assert settling(record(p=p, p_d=p_d, angle=np.zeros(N))) == pytest.approx(np.log(50.0) / 5.0, abs=2 * DT)


def test_settling_of_a_small_step_ends_within_a_millimetre() -> None:
    p, p_d = decaying(0.01, rate=5.0)
    assert settling(record(p=p, p_d=p_d, angle=np.zeros(N))) == pytest.approx(np.log(10.0) / 5.0, abs=2 * DT)


def test_settling_waits_for_the_orientation_too() -> None:
    angle, angle_d = decaying(np.radians(5.0), rate=4.0)
    of = record(p=np.zeros(N), p_d=np.zeros(N), angle=angle, angle_d=angle_d)
    assert settling(of) == pytest.approx(np.log(10.0) / 4.0, abs=2 * DT)


def test_what_never_comes_close_or_never_stands_does_not_settle() -> None:
    p, p_d = decaying(0.2, rate=0.1)
    assert settling(record(p=p, p_d=p_d, angle=np.zeros(N))) is None
    assert settling(record(p=TIME, p_d=TIME, angle=np.zeros(N))) is None


def test_coupling_is_what_the_other_half_does_while_one_half_moves() -> None:
    bump = 0.003 * np.exp(-(((TIME - 2.0) / 0.1) ** 2))
    angle, angle_d = decaying(0.1, rate=5.0)
    turned = figures(record(p=bump, p_d=np.zeros(N), angle=angle, angle_d=angle_d))
    assert turned.coupling_position_peak_mm == pytest.approx(3.0)
    assert turned.coupling_orientation_peak_deg is None
    p, p_d = decaying(0.1, rate=5.0)
    shifted = figures(record(p=p, p_d=p_d, angle=bump))
    assert shifted.coupling_orientation_peak_deg == pytest.approx(np.degrees(0.003))
    assert shifted.coupling_position_peak_mm is None


def test_roughness_of_a_ramp_is_its_slope() -> None:
    tau = np.zeros((N, 6))
    tau[:, 1] = 3.0 * TIME
    tau[:, 2] = 4.0 * TIME
    assert roughness(TIME, tau) == pytest.approx(5.0)
    assert roughness(TIME[:1], tau[:1]) == 0.0


def test_effort_is_the_rms_of_all_joints_together() -> None:
    tau = np.tile([3.0, 0.0, 4.0, 0.0, 0.0, 0.0], (N, 1))
    of = figures(record(p=np.zeros(N), p_d=np.zeros(N), angle=np.zeros(N), tau=tau))
    assert of.effort_Nm == pytest.approx(5.0)


def test_times_are_the_median_and_the_fifth_percentile() -> None:
    of = figures(record(p=np.zeros(N), p_d=np.zeros(N), angle=np.zeros(N), step_us=np.linspace(10.0, 110.0, N)))
    assert (of.step_median_us, of.step_p5_us) == pytest.approx((60.0, 15.0))


def test_a_record_of_one_cycle_has_figures() -> None:
    assert figures(record(p=np.zeros(1), p_d=np.ones(1), angle=np.zeros(1))).position_rmse_mm == pytest.approx(1e3)


def test_a_record_that_was_sent_to_another_process_has_the_same_figures() -> None:
    p, p_d = decaying(0.2, rate=5.0)
    sent = record(p=p, p_d=p_d, angle=np.zeros(N))
    received = pickle.loads(pickle.dumps(sent))
    assert figures(received) == figures(sent)
    assert not hasattr(received, "model")
