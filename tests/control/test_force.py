from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.control.force import ForceMotion
from burnish.core import Array, Dynamics, State, ToolReference
from burnish.errors import InputError
from burnish.model.friction import Friction
from burnish.model.model import Model
from burnish.model.spin import SpinningTip
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cellsim import WristFelt, simulated_job
from burnish.rotation import exp
from burnish.sim.arms import honest
from burnish.surface import DistanceGrid, Mould

MODEL = Model.jaco2()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
"""Far from every singularity: J⁻¹ exists, and Λ is not damped."""
NORMAL = np.array([0.2, -0.3, 1.0]) / np.linalg.norm([0.2, -0.3, 1.0])
DT = 1e-3
ARM = MODEL.at(State(t=0.0, q=HOME, dq=np.zeros(6)))


def at_rest(force: float = 0.0, t: float = 0.0) -> Dynamics:
    """The arm at home, the surface pushing on its tool along the normal."""
    return replace(ARM, t=t, F=np.concatenate([force * NORMAL, np.zeros(3)]))


def pressing(arm: Dynamics, force: float, v: Array | None = None) -> ToolReference:
    """Stay where the tool is, and press."""
    v = np.zeros(6) if v is None else v
    return ToolReference(p=arm.p, R=arm.R, v=v, a=np.zeros(6), normal=NORMAL, force=force)


def tool_wrench(arm: Dynamics, tau: Array) -> Array:
    """The wrench that a torque, less the arm's own, exerts at the tool of the arm at rest."""
    return np.linalg.solve(arm.J.T, tau - arm.h - arm.g)


def tool_acceleration(arm: Dynamics, tau: Array) -> Array:
    """What a torque does to the tool of the free arm."""
    return arm.J @ np.linalg.solve(arm.M, tau - arm.h - arm.g) + arm.dJdq


def feel(law: ForceMotion, force: float, wanted: float, cycles: int, t: float = 0.0) -> Array:
    """Wrenches at the tool in cycles in which a constant force is felt, (cycles, 6)."""
    wrenches = []
    for i in range(1, cycles + 1):
        arm = at_rest(force, t + DT * i)
        wrenches.append(tool_wrench(arm, law.torque(arm, pressing(arm, wanted))))
    return np.array(wrenches)


GAINS = {
    "position_frequency": 17.0,
    "orientation_frequency": 17.0,
    "force_gain": 0.0,
    "force_integral": 8.0,
    "normal_rate": 1e4,
}
"""Figures of these tests, so that they hold however the law is tuned."""


def fresh(**values: float) -> ForceMotion:
    law = ForceMotion(**(GAINS | values))
    law.reset(at_rest())
    return law


# Motion.


def random_case(seed: int) -> tuple[Dynamics, ToolReference]:
    rng = np.random.default_rng(seed)
    q, dq = HOME + rng.uniform(-0.2, 0.2, 6), rng.uniform(-0.5, 0.5, 6)
    arm = replace(MODEL.at(State(t=0.0, q=q, dq=dq)), F=rng.normal(size=6))
    R_d = exp(rng.uniform(-0.3, 0.3, 3)) @ arm.R
    wanted = ToolReference(p=arm.p + rng.uniform(-0.05, 0.05, 3), R=R_d, v=rng.normal(size=6), a=rng.normal(size=6))
    return arm, wanted


def test_without_a_normal_the_tool_moves_as_a_spring_and_a_damper() -> None:
    # By way of the joints: τ = M J⁻¹(a − J̇q̇) + h + g, with the rotation vector from the series of the logarithm.
    law = ForceMotion(position_frequency=15.0, orientation_frequency=9.0, damping_ratio=0.8)
    for seed in range(20):
        arm, wanted = random_case(seed)
        law.reset(arm)
        E = wanted.R @ arm.R.T
        theta = np.arccos((np.trace(E) - 1.0) / 2.0)
        turn = np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]) * theta / (2.0 * np.sin(theta))
        omega = np.repeat([15.0, 9.0], 3)
        e = np.concatenate([wanted.p - arm.p, turn])
        a = wanted.a + 2.0 * 0.8 * omega * (wanted.v - arm.J @ arm.dq) + omega**2 * e
        tau = arm.M @ np.linalg.solve(arm.J, a - arm.dJdq) + arm.h + arm.g
        # The condition numbers of J and M, together below 1e6, take six digits.
        assert_allclose(law.torque(arm, wanted), tau, rtol=1e-8, atol=1e-9)


def test_without_a_normal_the_felt_force_does_not_matter() -> None:
    arm, wanted = random_case(1)
    law = fresh()
    quiet = law.torque(arm, wanted)
    law.reset(arm)
    assert_allclose(law.torque(replace(arm, F=np.full(6, 9.0)), wanted), quiet, atol=0.0)


@pytest.mark.parametrize("share", [0.25, 1.0, 2.0])
def test_reference_sets_the_stiffness_along_the_path_and_the_damping_ratio_stays(share: float) -> None:
    law = ForceMotion(position_frequency=15.0, orientation_frequency=15.0, damping_ratio=0.8)
    other = ForceMotion(
        position_frequency=15.0 * share**0.5, orientation_frequency=15.0 * share**0.5, damping_ratio=0.8
    )
    for seed in range(5):
        arm, wanted = random_case(seed)
        law.reset(arm)
        other.reset(arm)
        found = law.torque(arm, replace(wanted, stiffness=share))
        assert_allclose(found, other.torque(arm, wanted), rtol=1e-10, atol=1e-12)


def test_position_error_is_integrated() -> None:
    law = fresh(position_frequency=17.0, position_integral=0.5)
    arm = at_rest()
    wanted = replace(pressing(arm, 0.0), p=arm.p + [0.01, 0.0, 0.0], normal=None)
    first, last = (tool_acceleration(arm, law.torque(replace(arm, t=t), wanted)) for t in (0.0, 1.0))
    # ω² of 289, a share of 0.5 of it a second, 10 mm for one second.
    assert_allclose(last - first, [289.0 * 0.5 * 0.01, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-8)


def test_motion_integral_is_bounded() -> None:
    law = fresh(integral_acceleration=2.0)
    arm = at_rest()
    wanted = replace(pressing(arm, 0.0), p=arm.p + [0.01, 0.0, -0.01], normal=None)
    first = tool_acceleration(arm, law.torque(arm, wanted))
    for i in range(1, 101):
        last = tool_acceleration(arm, law.torque(replace(arm, t=float(i)), wanted))
    assert_allclose(last - first, [2.0, 0.0, -2.0, 0.0, 0.0, 0.0], atol=1e-8)


# Force.


def test_in_contact_the_tool_presses_against_the_normal_with_the_wanted_force() -> None:
    # A second is 25 time constants of the contact; the felt force is the wanted one, so no feedback acts.
    wrench = feel(fresh(), force=8.0, wanted=8.0, cycles=1000)[-1]
    assert_allclose(wrench, [*(-8.0 * NORMAL), 0.0, 0.0, 0.0], atol=1e-6)


def test_force_feedback_presses_harder_where_too_little_is_felt() -> None:
    wrench = feel(fresh(force_gain=0.5, force_integral=0.0), force=6.0, wanted=8.0, cycles=1000)[-1]
    assert -wrench[:3] @ NORMAL == pytest.approx(8.0 + 0.5 * 2.0, abs=1e-6)


def test_force_feedback_gives_way_where_too_much_is_felt() -> None:
    wrench = feel(fresh(force_gain=0.5, force_integral=0.0), force=10.0, wanted=8.0, cycles=1000)[-1]
    assert -wrench[:3] @ NORMAL == pytest.approx(8.0 - 0.5 * 2.0, abs=1e-6)


def test_force_integral_grows_with_the_error_and_the_time() -> None:
    wrench = feel(fresh(force_integral=1.5), force=6.0, wanted=8.0, cycles=1000)[-1]
    assert -wrench[:3] @ NORMAL == pytest.approx(8.0 + 1.5 * 2.0 * 1.0, abs=1e-6)


@pytest.mark.parametrize(("felt", "share"), [(2.0, 6.0), (30.0, -6.0)])
def test_force_integral_is_bounded_both_ways(felt: float, share: float) -> None:
    wrench = feel(fresh(integral_force=6.0), force=felt, wanted=10.0, cycles=1000)[-1]
    assert -wrench[:3] @ NORMAL == pytest.approx(10.0 + share, abs=1e-6)


def test_in_contact_position_along_the_normal_is_left_to_the_force() -> None:
    law = fresh()
    feel(law, 8.0, 8.0, 1000)
    arm = at_rest(8.0, 1.0 + DT)
    wanted = pressing(arm, 8.0)
    off = replace(wanted, p=wanted.p + 0.01 * NORMAL)
    assert_allclose(tool_wrench(arm, law.torque(arm, off)), [*(-8.0 * NORMAL), 0.0, 0.0, 0.0], atol=1e-6)


def test_in_contact_position_along_the_surface_is_held() -> None:
    law = fresh(position_frequency=17.0, position_integral=0.0)
    feel(law, 8.0, 8.0, 1000)
    arm = at_rest(8.0, 1.0 + DT)
    along = np.cross(NORMAL, [1.0, 0.0, 0.0])
    wanted = replace(pressing(arm, 8.0), p=arm.p + 0.001 * along)
    wrench = tool_wrench(arm, law.torque(arm, wanted)) + np.array([*(8.0 * NORMAL), 0.0, 0.0, 0.0])
    acceleration = np.linalg.solve(np.linalg.inv(arm.J @ np.linalg.solve(arm.M, arm.J.T)), wrench)
    assert_allclose(acceleration, [*(17.0**2 * 0.001 * along), 0.0, 0.0, 0.0], atol=1e-5)


def test_motion_along_the_normal_is_damped() -> None:
    law = fresh(normal_damping=300.0)
    feel(law, 8.0, 8.0, 1000)
    # The reference moves away from the surface, the tool does not: as if the tool moved into it.
    arm = at_rest(8.0, 1.0 + DT)
    wanted = pressing(arm, 8.0, v=np.concatenate([0.01 * NORMAL, np.zeros(3)]))
    assert tool_wrench(arm, law.torque(arm, wanted))[:3] @ NORMAL == pytest.approx(-8.0 + 300.0 * 0.01, abs=1e-6)


def test_light_tool_is_damped_along_the_normal_no_harder_than_the_loop_can_follow() -> None:
    arm = at_rest(8.0, 1.0 + DT)
    felt = 1.0 / float(NORMAL @ (arm.J @ np.linalg.solve(arm.M, arm.J.T))[:3, :3] @ NORMAL)
    for rate in (20.0, 40.0):
        law = fresh(normal_damping=300.0, normal_rate=rate)
        feel(law, 8.0, 8.0, 1000)
        wanted = pressing(arm, 8.0, v=np.concatenate([0.01 * NORMAL, np.zeros(3)]))
        push = float(tool_wrench(arm, law.torque(arm, wanted))[:3] @ NORMAL)
        assert rate * felt < 300.0
        assert push == pytest.approx(-8.0 + rate * felt * 0.01, abs=1e-6)


def test_friction_of_the_surface_is_fed_forward_along_the_motion() -> None:
    along = np.cross(NORMAL, [1.0, 0.0, 0.0])
    along /= np.linalg.norm(along)
    wrenches = []
    for friction in (0.0, 0.3):
        law = fresh(surface_friction=friction)
        feel(law, 8.0, 8.0, 1000)
        arm = at_rest(8.0, 1.0 + DT)
        v = np.concatenate([0.05 * along, np.zeros(3)])
        wrenches.append(tool_wrench(arm, law.torque(arm, pressing(arm, 8.0, v=v))))
    # Smooth about standstill: at 50 mm/s it is 0.1 % below µ f.
    assert_allclose(wrenches[1] - wrenches[0], [*(0.3 * 8.0 * along), 0.0, 0.0, 0.0], atol=2e-3 * 2.4)


@pytest.mark.parametrize("ahead", [0.0, 0.03])
def test_friction_is_that_of_the_planned_motion_when_the_torque_acts(ahead: float) -> None:
    friction = Friction(coulomb=np.ones(6), viscous=np.arange(1.0, 7.0))
    arm, wanted = random_case(2)
    laws = [ForceMotion(), ForceMotion(friction=friction, friction_share=0.7, friction_ahead=ahead)]
    for law in laws:
        law.reset(arm)
    plain, compensated = (law.torque(arm, wanted) for law in laws)
    then = np.linalg.solve(arm.J, wanted.v + ahead * wanted.a)
    assert_allclose(compensated - plain, 0.7 * friction.torque(then), atol=1e-8)


# Contact found and lost.


def test_in_the_air_the_tool_is_held_by_position_alone() -> None:
    law = fresh(seek_speed=0.0)
    assert_allclose(feel(law, force=0.0, wanted=8.0, cycles=200), np.zeros((200, 6)), atol=1e-8)


def test_in_the_air_the_tool_seeks_at_its_speed_down_to_its_depth() -> None:
    law = fresh(seek_speed=5e-3, seek_depth=4e-3, position_frequency=10.0)
    for i in range(1, 1501):
        arm = at_rest(0.0, DT * i)
        a = tool_acceleration(arm, law.torque(arm, pressing(arm, 8.0)))
        # Position feedback on a reference that sinks: ω² times its depth.
        sunk = -float(a[:3] @ NORMAL) / 10.0**2
        assert sunk == pytest.approx(min(5e-3 * DT * i, 4e-3), abs=1e-9)


def test_stuck_joints_are_helped_to_seek() -> None:
    friction = Friction(coulomb=np.ones(6), viscous=np.zeros(6))
    laws = [fresh(seek_speed=5e-3, seek_depth=4e-3), fresh(seek_speed=5e-3, seek_depth=4e-3)]
    laws[1].friction = friction
    laws[1].friction_share = 0.8
    helped = []
    for i in range(1, 1001):
        arm = at_rest(0.0, DT * i)
        plain, compensated = (law.torque(arm, pressing(arm, 8.0)) for law in laws)
        helped.append(compensated - plain)
    down = np.linalg.solve(ARM.J, np.concatenate([-5e-3 * NORMAL, np.zeros(3)]))
    # On the way down in full; at its end, 4 mm at 5 mm/s, no more, and nowhere with a jump: 0.1 mm is 20 cycles.
    assert_allclose(helped[400], 0.8 * friction.torque(down), atol=1e-6)
    assert_allclose(helped[-1], np.zeros(6), atol=1e-9)
    assert np.abs(np.diff(helped, axis=0)).max() < 0.8 * 0.2


@pytest.mark.parametrize(("rate", "share"), [(20.0, 1.0), (5.0, 0.5), (0.0, 0.0), (-5.0, -0.5), (-20.0, -1.0)])
def test_stuck_joints_are_helped_to_press_more_and_less(rate: float, share: float) -> None:
    friction = Friction(coulomb=np.ones(6), viscous=np.zeros(6))
    laws = [fresh(seek_speed=5e-3), fresh(seek_speed=5e-3, friction_share=0.8)]
    laws[1].friction = friction
    for i in range(1, 401):
        arm = at_rest(8.0, DT * i)
        wanted = pressing(arm, 8.0 + DT * i * rate)
        plain, compensated = (law.torque(arm, wanted) for law in laws)
    down = np.linalg.solve(ARM.J, np.concatenate([-share * 5e-3 * NORMAL, np.zeros(3)]))
    assert_allclose(compensated - plain, 0.8 * friction.torque(down), atol=1e-4)


def test_the_first_set_force_is_not_one_that_rises() -> None:
    laws = [fresh(fade_time=1e-6), fresh(fade_time=1e-6)]
    laws[1].friction = Friction(coulomb=np.ones(6), viscous=np.zeros(6))
    for start in (0.0, 5.0):
        arm = at_rest(8.0, start + DT)
        plain, compensated = (law.torque(arm, pressing(arm, 8.0)) for law in laws)
        assert_allclose(compensated, plain, atol=1e-9)
        for law in laws:
            law.reset(at_rest(t=5.0))


def test_a_set_force_after_free_motion_is_not_one_that_falls() -> None:
    laws = [fresh(fade_time=1e-6), fresh(fade_time=1e-6)]
    laws[1].friction = Friction(coulomb=np.ones(6), viscous=np.zeros(6))
    for i, (normal, force) in enumerate([(NORMAL, 8.0), (None, 0.0), (NORMAL, 2.0)], start=1):
        arm = at_rest(8.0, DT * i)
        wanted = replace(pressing(arm, force), normal=normal)
        plain, compensated = (law.torque(arm, wanted) for law in laws)
        assert_allclose(compensated, plain, atol=1e-9)


def test_lost_contact_fades_without_a_jump() -> None:
    law = fresh(fade_time=0.04, seek_speed=5e-3, position_frequency=17.0)
    before = feel(law, 8.0, 8.0, 1000)[-1]
    after = feel(law, 0.0, 8.0, 400, t=1.0)
    steps = np.linalg.norm(np.diff(np.vstack([before, after])[:, :3], axis=0), axis=1)
    # 8 N through 40 ms is 0.2 N a cycle; seeking at 5 mm/s under ω² = 289/s² and Λ below 10 kg adds 0.015 N.
    assert steps.max() < 0.22


def test_pressing_force_is_gone_after_the_contact() -> None:
    law = fresh(seek_speed=0.0)
    feel(law, 8.0, 8.0, 1000)
    assert np.linalg.norm(feel(law, 0.0, 8.0, 1000, t=1.0)[-1]) < 1e-6


def test_found_contact_takes_up_the_force_without_a_jump() -> None:
    law = fresh(force_integral=0.0, fade_time=0.04, seek_speed=5e-3, position_frequency=17.0)
    feel(law, 0.0, 8.0, 100)
    wrenches = feel(law, 8.0, 8.0, 400, t=0.1)
    assert np.linalg.norm(np.diff(wrenches[:, :3], axis=0), axis=1).max() < 0.22


def test_lost_contact_does_not_wind_the_force_integral_up() -> None:
    law = fresh(integral_force=6.0, seek_speed=5e-3)
    feel(law, 0.0, 8.0, 1000)
    wrench = feel(law, 8.0, 8.0, 1000, t=1.0)[-1]
    assert -wrench[:3] @ NORMAL == pytest.approx(8.0, abs=1e-6)


def test_reset_forgets_contact_and_integrals() -> None:
    law = fresh()
    feel(law, 2.0, 8.0, 1000)
    arm = at_rest(0.0, 1.0)
    law.reset(arm)
    assert_allclose(law.torque(arm, pressing(arm, 8.0)), arm.g, atol=1e-9)


def test_arm_that_feels_nothing_is_refused_before_it_moves() -> None:
    with pytest.raises(InputError, match="WristSense or a JointSense"):
        ForceMotion().reset(replace(at_rest(), F=None))


@pytest.mark.parametrize("name", ["position_frequency", "orientation_frequency", "damping_ratio", "fade_time", "tank"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_figure_that_is_not_positive_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} ="):
        ForceMotion(**{name: value})


# Energy tank.


def pushed_into_nothing(law: ForceMotion, seconds: float) -> tuple[float, float, float]:
    """Work of force and integrals on the free arm, what its dampers took [J], and the tool's way along −n [m].

    The tool has touched for a second when what it touches gives way; the sensor is stuck at 4 N, 10 N are wanted. What
    is left of the wrench, once the spring and the dampers of the motion are taken off, is what force and integrals push
    with.
    """
    feel(law, 10.0, 10.0, 1000)
    q, dq, work, damped = HOME.copy(), np.zeros(6), 0.0, 0.0
    start, omega, P = pressing(ARM, 10.0), law.position_frequency, np.eye(6)
    P[:3, :3] -= np.outer(NORMAL, NORMAL)
    for i in range(1, round(seconds / DT)):
        state = State(t=1.0 + DT * i, q=q, dq=dq)
        arm = replace(MODEL.at(state), F=np.concatenate([4.0 * NORMAL, np.zeros(3)]))
        tau = law.torque(arm, start)
        E = start.R @ arm.R.T
        turn = 0.5 * np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
        e = np.concatenate([start.p - arm.p, turn])
        passive = arm.Lambda @ (P @ (omega**2 * e - 2.0 * omega * arm.v) - arm.dJdq)
        passive[:3] -= law.normal_damping * NORMAL * (NORMAL @ arm.v[:3])
        work += DT * float((tool_wrench(arm, tau) - passive) @ arm.v)
        damped += DT * max(0.0, 2.0 * omega * float((P @ arm.v) @ arm.Lambda @ arm.v))
        dq = dq + DT * np.linalg.solve(arm.M, tau - arm.h - arm.g)
        q = q + DT * dq
    return work, damped, -float((arm.p - start.p) @ NORMAL)


@pytest.mark.parametrize(("damping", "seconds"), [(0.0, 0.2), (260.0, 2.0)])
def test_force_puts_in_no_more_than_the_tank_and_the_dampers_give(damping: float, seconds: float) -> None:
    law = fresh(normal_damping=damping, tank=0.1)
    work, damped, _ = pushed_into_nothing(law, seconds)
    # Emptied: the bound is reached. Without D_n the light arm comes to 1 m/s; the rounding of its torques is 1e-9 J.
    assert law.energy < 0.1 / 6.0
    assert work <= 0.1 + damped + law.supply * seconds + 1e-6
    assert work > 0.08


def test_tool_lunges_no_farther_than_the_tank_lasts() -> None:
    law = fresh(tank=0.1, supply=0.0)
    _, _, way = pushed_into_nothing(law, 2.0)
    # f is 10 N and more; the last sixth of the tank fades, and the tool coasts for 10 kg/260 N·s/m at 0.05 m/s.
    assert way < 0.1 / 10.0 + 2e-3
    assert law.energy < 0.1 / 6.0


def test_tool_with_an_empty_tank_creeps_by_what_is_supplied() -> None:
    laws = [fresh(tank=0.1) for _ in range(2)]
    ways = [pushed_into_nothing(law, seconds)[2] for law, seconds in zip(laws, (1.5, 2.0), strict=True)]
    # D_n v² = supply.
    assert (ways[1] - ways[0]) / 0.5 == pytest.approx((laws[0].supply / laws[0].normal_damping) ** 0.5, rel=0.2)


def test_tool_without_a_tank_would_go_on() -> None:
    _, _, way = pushed_into_nothing(fresh(tank=1e6), 1.0)
    assert way > 0.03


def test_empty_tank_takes_force_and_integrals_away_and_leaves_the_rest() -> None:
    law = fresh()
    feel(law, 6.0, 8.0, 1000)
    law._tank.add(-1.0)
    arm = at_rest(6.0, 1.0 + DT)
    assert_allclose(tool_wrench(arm, law.torque(arm, pressing(arm, 8.0))), np.zeros(6), atol=1e-6)


def test_tool_that_stands_and_presses_takes_nothing_from_the_tank() -> None:
    law = fresh(tank=0.1)
    feel(law, 6.0, 8.0, 3000)
    assert law.energy == 0.1


def test_tank_is_refilled_by_what_friction_eats_in_any_case() -> None:
    law = fresh(tank=0.1, supply=5e-3)
    feel(law, 6.0, 8.0, 1000)
    law._tank.add(-0.05)
    feel(law, 6.0, 8.0, 2000)
    # A second at rest: a pass of a quarter of an hour does not run dry by friction alone.
    assert law.energy == pytest.approx(0.05 + 5e-3, abs=1e-5)


def test_reset_fills_the_tank() -> None:
    law = fresh(tank=0.1)
    law._tank.add(-0.1)
    law.reset(at_rest())
    assert law.energy == 0.1


# A tip that spins, and one that is stiff.


def test_drag_of_a_spinning_tip_is_fed_forward_at_the_planned_tilt() -> None:
    tip = SpinningTip(spindle=200.0, friction=0.3, radius=0.02, modulus=2e6)
    wrenches = []
    for spinning in (None, tip):
        law = ForceMotion(**GAINS, surface_friction=0.0, spinning=spinning)
        law.reset(at_rest())
        feel(law, 8.0, 8.0, 1000)
        arm = at_rest(8.0, 1.0 + DT)
        wrenches.append(tool_wrench(arm, law.torque(arm, pressing(arm, 8.0))))
    force, moment = tip.drag(8.0, NORMAL.tolist(), ARM.R[:, 2].tolist(), (0.0, 0.0, 0.0))
    # 25 time constants after the touch c is 1 to eleven digits.
    assert_allclose(wrenches[1] - wrenches[0], [-x for x in (*force, *moment)], atol=1e-8)
    assert np.linalg.norm(force) > 1.0


def test_spindle_hardly_leaves_friction_to_feed_forward_along_the_path() -> None:
    tip = SpinningTip(spindle=500.0, friction=0.3, radius=0.02, modulus=2e6)
    along = np.cross(NORMAL, [1.0, 0.0, 0.0]) / np.linalg.norm(np.cross(NORMAL, [1.0, 0.0, 0.0]))
    upright = tip.drag(8.0, NORMAL.tolist(), (-NORMAL).tolist(), (0.02 * along).tolist())[0]
    assert np.linalg.norm(upright) < 0.05 * 0.3 * 8.0


def test_gains_along_the_normal_fall_with_the_stiffness_of_the_tip() -> None:
    law = ForceMotion(normal_damping=260.0, normal_rate=24.0, force_gain=0.1, force_integral=8.0)
    assert law.against(12e3) == law
    assert law.against(5e3) == law
    stiff = law.against(100e3)
    # 12 and 100 kN/m, each behind 100 kN/m of felt: 10.7 and 50 kN/m.
    share = (12.0 * 100.0 / 112.0) / 50.0
    found = (stiff.normal_damping, stiff.normal_rate, stiff.force_gain, stiff.force_integral)
    assert found == pytest.approx((260.0 * share, 24.0 * share, 0.1 * share**2, 8.0 * share**0.5))


@pytest.mark.slow
def test_polishing_does_not_come_near_the_end_of_the_tank() -> None:
    grid = DistanceGrid.of(Mould.load("plate", "mm"))
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    top = float(Mould.load("plate", "mm").vertices[:, 2].max())
    points = np.column_stack([0.03 * np.cos(angle), 0.03 * np.sin(angle), np.full(200, top)])
    normals, even = np.tile([0.0, 0.0, 1.0], (200, 1)), np.ones(200)
    stroke = Stroke(points=points, normals=normals, feed=0.02 * even, force=10.0 * even)
    job, robot = simulated_job(
        grid, [stroke], honest(1), rate=100.0, felt=WristFelt(), tool=PolishingTool(), on_phase=lambda phase: None
    )
    with robot:
        levels = [job.law.energy for _ in job.run() if job.phase == "pass"]
    assert len(levels) > 500
    # Below a sixth force and integrals would be scaled down.
    assert min(levels) > 0.5 * job.law.tank
