"""Our gains of the laws, from what the arm is: exact and at 1 kHz, or late, with friction, and at 100 Hz."""

from __future__ import annotations

from burnish.control import (
    ComputedTorque,
    Hybrid,
    HybridNullSpace,
    Impedance,
    InertiaShapingImpedance,
    OperationalSpace,
    RedundantImpedance,
    TaskComputedTorque,
)
from burnish.sim.arms import Arm

FREQUENCY = 25.0
"""ω of a law that knows M, at 1 kHz on an exact model [rad/s]."""
HONEST_FREQUENCY = 18.0
"""The same at 100 Hz [rad/s]: at the crossover 2 ζ ω = 36 rad/s the delay and the hold, 15 ms, take 31° of phase, which
leaves room for rotors that are 30 % off."""
INTEGRAL_SHARE = 1.5
"""K_i/K_p on the honest arm [1/s]: a standing error of friction falls to a third in 0.7 s."""
INTEGRAL_BOUND = (6.0, 90.0)
"""Of K_i ∫e [m/s², rad/s²]: 6 kg at the tool and 0.15 kg·m² of a wrist rotor make 36 N and 13 N·m of it, more than
friction takes."""
STIFFNESS, HONEST_STIFFNESS = (800.0, 10.0), (1500.0, 25.0)
"""Of the impedances [N/m, N·m/rad]; the rotors of the honest arm allow more, and its friction asks for it."""
DAMPING_RATIO = 1.0


def _rough(arm: Arm) -> bool:
    return arm.friction is not None


def computed_torque(arm: Arm) -> ComputedTorque:
    """By natural frequency; against friction its compensation and an integral."""
    if not _rough(arm):
        return ComputedTorque.at_frequency(FREQUENCY)
    return ComputedTorque.at_frequency(HONEST_FREQUENCY, ki=INTEGRAL_SHARE * HONEST_FREQUENCY**2, friction=arm.friction)


def task_computed_torque(arm: Arm) -> TaskComputedTorque:
    """By natural frequency; against friction an integral."""
    if not _rough(arm):
        return TaskComputedTorque.at_frequency(FREQUENCY)
    return TaskComputedTorque.at_frequency(
        HONEST_FREQUENCY, ki=INTEGRAL_SHARE * HONEST_FREQUENCY**2, integral=INTEGRAL_BOUND
    )


def impedance(arm: Arm) -> Impedance:
    """By stiffness and damping ratio, with the arm's own dynamics fed forward."""
    return Impedance.from_stiffness(_stiffness(arm), DAMPING_RATIO, feed_forward=1.0)


def force_sensing(arm: Arm) -> InertiaShapingImpedance:
    """By stiffness and damping ratio."""
    return InertiaShapingImpedance.from_stiffness(_stiffness(arm), DAMPING_RATIO)


def redundant(arm: Arm) -> RedundantImpedance:
    """By stiffness and damping ratio."""
    return RedundantImpedance.from_stiffness(_stiffness(arm), DAMPING_RATIO)


def hybrid(arm: Arm) -> Hybrid:
    """Joint speeds fast enough to turn with the operator, and a position stiff enough to move them."""
    if not _rough(arm):
        return Hybrid(stiffness=16000.0, damping=100.0, turn_rate=160.0, speed_gain=160.0)
    return Hybrid(stiffness=3000.0, damping=40.0, turn_rate=6.0, speed_gain=12.0)


def hybrid_null_space(arm: Arm) -> HybridNullSpace:
    """The brake of the joint speeds leaves the position alone, so that one is damped by itself."""
    if not _rough(arm):
        return HybridNullSpace(stiffness=2000.0, damping=80.0, turn_rate=15.0, speed_gain=60.0)
    return HybridNullSpace(stiffness=2500.0, damping=120.0, turn_rate=10.0, speed_gain=30.0)


def operational_space(arm: Arm) -> OperationalSpace:
    """One better than all of them: rotors in Λ, friction at the planned speed, an integral for what is left."""
    if not _rough(arm):
        return OperationalSpace.at_frequency(FREQUENCY)
    return OperationalSpace.at_frequency(
        HONEST_FREQUENCY,
        ki=INTEGRAL_SHARE * HONEST_FREQUENCY**2,
        integral=INTEGRAL_BOUND,
        friction=arm.friction,
    )


def _stiffness(arm: Arm) -> tuple[float, float]:
    return HONEST_STIFFNESS if _rough(arm) else STIFFNESS
