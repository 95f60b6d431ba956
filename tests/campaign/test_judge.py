"""The judge finds each thing that may be wrong in a log, and finds nothing in a good one."""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from burnish.campaign import judge as module
from burnish.campaign.judge import judge, load_limits

LIMITS = load_limits()
T = 0.01
N = 250
STOP = 100


def quiet(stopped: bool = True) -> tuple[dict[str, Any], dict[str, Any]]:
    """A log of an arm that moves slowly, has an urgent fault in row 100, is held in it, and stands at once."""
    t = T * np.arange(N)
    moving = t < t[STOP]
    dq = np.where(moving[:, None], 0.1, 0.0) * np.ones(6)
    weight = np.tile([0.0, 8.0, 4.0, 0.5, 0.2, 0.0], (N, 1))
    log = {
        "t": t,
        "told": t.copy(),
        "q": np.cumsum(dq, axis=0) * T,
        "dq": dq,
        "tau": weight.copy(),
        "sent": np.ones(N),
        "held": np.where(moving, 0.0, float(stopped)),
        "p": np.zeros((N, 3)),
        "weight": weight,
        "force": np.zeros(N),
        "energy": np.where(moving, 0.05, 0.0),
    }
    return log, {"fault_at": float(t[STOP]), "urgency": "invalid"}


def test_nothing_is_found_in_a_good_log() -> None:
    log, header = quiet()
    verdict = judge(log, header, LIMITS)
    assert verdict.unsafe == 0
    assert (verdict.reaction, verdict.late, verdict.moving, verdict.still_after) == (0, False, False, 0.0)
    assert verdict.stopped_at == pytest.approx(1.0)
    assert verdict.peak_speed == pytest.approx(np.degrees(0.1) / 36.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_torque_that_is_no_number_is_one_unsafe_sample(value: float) -> None:
    log, header = quiet()
    log["tau"][40, 2] = value
    verdict = judge(log, header, LIMITS)
    assert (verdict.not_finite, verdict.unsafe) == (1, 1)


def test_torque_over_its_cap_is_found() -> None:
    log, header = quiet(stopped=False)
    # Slowly up and down again, so that it breaks no other rule.
    log["tau"][:, 5] = 7.0 * np.sin(np.pi * log["t"] / log["t"][-1])
    over = int((log["tau"][:, 5] > 6.8).sum())
    verdict = judge(log, header, LIMITS)
    assert over > 0
    assert (verdict.over_cap, verdict.unsafe) == (over, over)


def test_jump_of_a_torque_is_found_and_the_allowed_rate_is_not() -> None:
    log, header = quiet()
    log["tau"][50:60, 0] = 3.0
    assert judge(log, header, LIMITS).over_rate == 0
    log["tau"][50:60, 0] = 3.01
    assert judge(log, header, LIMITS).over_rate == 2


def test_rate_counts_from_the_last_torque_that_was_sent() -> None:
    log, header = quiet()
    log["sent"][50:53] = 0.0
    log["tau"][53:60, 0] = 11.9
    log["tau"][60:, 0] = np.maximum(0.0, 11.9 - 3.0 * np.arange(1, N - 59))
    assert judge(log, header, LIMITS).over_rate == 0


def test_push_while_the_arm_is_held_is_found_after_the_grace_only() -> None:
    log, header = quiet()
    log["tau"][STOP + 5 : STOP + 10, 0] += 2.9
    assert judge(log, header, LIMITS).not_held == 0
    log["tau"][STOP + 20 : STOP + 60, 0] += np.minimum(15.0, 2.9 * np.arange(1, 41))
    log["tau"][STOP + 60 :, 0] += np.maximum(0.0, 15.0 - 2.9 * np.arange(1, N - STOP - 59))
    verdict = judge(log, header, LIMITS)
    assert verdict.over_rate == 0
    assert verdict.not_held > 30


def test_spring_back_to_where_the_arm_was_stopped_is_a_hold() -> None:
    log, header = quiet()
    log["q"][STOP + 5 :, 1] += 0.2
    log["tau"][STOP + 10 :, 1] -= np.minimum(24.0, 3.0 * np.arange(1, N - STOP - 9))
    assert judge(log, header, LIMITS).not_held == 0


REACTIONS = [("invalid", 1, False), ("invalid", 2, True), ("stale", 2, False), ("stale", 3, True), ("frozen", 3, True)]


@pytest.mark.parametrize(("urgency", "delay", "late"), REACTIONS)
def test_reaction_is_late_from_its_limit_on(urgency: str, delay: int, late: bool) -> None:
    log, header = quiet()
    header |= {"fault_at": float(log["t"][STOP - delay]), "urgency": urgency}
    verdict = judge(log, header, LIMITS)
    assert (verdict.reaction, verdict.late) == (delay, late)


def test_cycles_in_which_the_controller_was_given_nothing_are_none_of_its_reaction() -> None:
    log, header = quiet()
    header["fault_at"] = float(log["t"][STOP - 30])
    log["sent"][STOP - 30 : STOP] = 0.0
    assert judge(log, header, LIMITS).reaction == 0


def test_urgent_fault_without_a_stop_is_late_and_another_is_not() -> None:
    log, header = quiet(stopped=False)
    assert judge(log, header, LIMITS).late
    assert not judge(log, header | {"urgency": None}, LIMITS).late


def test_stop_counts_only_when_the_arm_stands() -> None:
    log, header = quiet()
    log["dq"][STOP:, 3] = np.radians(1.1)
    verdict = judge(log, header, LIMITS)
    assert verdict.moving
    assert verdict.still_after is None


def test_time_to_rest_ends_with_the_last_fast_row() -> None:
    log, header = quiet()
    log["dq"][STOP : STOP + 30, 3] = np.radians(5.0)
    verdict = judge(log, header, LIMITS)
    assert verdict.still_after == pytest.approx(0.30)
    assert not verdict.moving
    assert not verdict.slow_stop
    log["dq"][STOP : STOP + 90, 3] = np.radians(5.0)
    assert judge(log, header, LIMITS).slow_stop


def test_arm_that_nobody_could_see_is_not_judged_for_its_rest() -> None:
    log, header = quiet()
    log["told"][STOP:] = log["told"][STOP]
    log["dq"][STOP + 40 :, 3] = 0.5
    log["p"][STOP + 40 :, 0] = 0.3
    verdict = judge(log, header, LIMITS)
    assert not verdict.moving
    assert verdict.drift == 0.0
    assert verdict.watched == pytest.approx(0.25)


def test_drift_is_the_farthest_way_after_the_stop_within_two_seconds() -> None:
    log, header = quiet()
    log["p"][:STOP, 0] = 0.5
    log["p"][STOP + 30, 1] = 0.04
    assert judge(log, header, LIMITS).drift == pytest.approx(0.04)


def test_fastest_joint_counts_by_its_own_limit() -> None:
    log, header = quiet()
    log["dq"][10, 5] = np.radians(60.0)
    assert judge(log, header, LIMITS).peak_speed == pytest.approx(60.0 / 48.0)


def test_the_judge_shares_no_code_with_what_it_judges() -> None:
    tree = ast.parse(Path(module.__file__).read_text())
    found = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    found |= {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    foreign = {name.split(".")[0] for name in found} - set(sys.stdlib_module_names)
    assert foreign == {"numpy"}


def test_limits_of_the_judge_are_no_wider_than_those_of_the_supervisor() -> None:
    supervisor = json.loads((module.LIMITS.parent / "jaco2_limits.json").read_text())
    assert LIMITS["torque_Nm"] <= supervisor["torque"]
    assert LIMITS["torque_rate_Nm_s"] <= supervisor["torque_rate"]
    assert np.all(np.radians(LIMITS["speed_deg_s"]) <= np.array(supervisor["speed"]) + 1e-12)
