from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import InputError
from burnish.model.friction import Friction

JOINTS = Friction(coulomb=np.array([2.0, 1.0]), viscous=np.array([2.5, 0.6]), breakaway=np.array([3.0, 1.7]))
PLAIN = Friction(coulomb=np.array([2.0, 1.0]), viscous=np.array([2.5, 0.6]))


def test_fast_joint_has_coulomb_and_viscous_friction_of_the_sign_of_its_speed() -> None:
    for friction in (JOINTS, PLAIN):
        np.testing.assert_allclose(friction.torque(np.array([0.8, -0.8])), [2.0 + 2.5 * 0.8, -1.0 - 0.6 * 0.8])


def test_friction_is_smooth_and_odd_through_zero_speed() -> None:
    dq = np.linspace(-0.01, 0.01, 20_001)
    torque = np.array([JOINTS.torque(np.full(2, speed)) for speed in dq])
    np.testing.assert_array_equal(JOINTS.torque(np.zeros(2)), np.zeros(2))
    np.testing.assert_allclose(torque, -torque[::-1], atol=1e-14)
    steepest = np.array([3.0, 1.7]) / JOINTS.transition_velocity + np.array([2.5, 0.6])
    assert (np.abs(np.diff(torque, axis=0)) <= steepest * (dq[1] - dq[0]) * (1 + 1e-9)).all()


def test_starting_takes_nearly_the_breakaway_torque_and_sliding_less() -> None:
    dq = np.linspace(0.0, 0.3, 3001)
    torque = np.array([JOINTS.torque(np.full(2, speed)) for speed in dq])
    peak = torque[dq < 0.05].max(axis=0)
    assert (peak > 0.9 * np.array([3.0, 1.7])).all()
    assert (peak <= np.array([3.0, 1.7]) + 0.05 * np.array([2.5, 0.6])).all()
    at_twice_stribeck = torque[1000] - JOINTS.viscous * dq[1000]
    np.testing.assert_allclose(at_twice_stribeck, [2.0, 1.0], rtol=0.02)


def test_without_breakaway_there_is_no_stribeck_effect() -> None:
    dq = np.linspace(0.0, 0.3, 301)
    torque = np.array([PLAIN.torque(np.full(2, speed)) for speed in dq])
    assert (np.diff(torque, axis=0) > 0).all()
    assert (torque - PLAIN.viscous * dq[:, None] <= PLAIN.coulomb).all()


def test_friction_only_ever_takes_power() -> None:
    for dq in np.random.default_rng(1).normal(size=(1000, 2)) * np.logspace(-6, 2, 1000)[:, None]:
        assert (dq * JOINTS.torque(dq) >= 0).all()


def test_sliding_mass_stops_and_stays() -> None:
    q, dq, dt = 0.0, 1.0, 1e-4
    friction = Friction(coulomb=np.array([2.0]), viscous=np.array([0.5]), breakaway=np.array([3.0]))
    for _ in range(20_000):
        dq -= dt * float(friction.torque(np.array([dq]))[0])  # 1 kg·m²
        q += dt * dq
    assert 0.0 <= dq < 1e-9
    assert 0.0 < q < 1.0**2 / (2 * 2.0)  # Coulomb friction alone would need v²/(2 a)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"coulomb": np.array([-1.0, 1.0])}, "negative"),
        ({"viscous": np.array([np.nan, 1.0])}, "finite"),
        ({"breakaway": np.array([0.5, 0.5])}, "below coulomb"),
        ({"viscous": np.array([1.0])}, "one number a joint"),
        ({"coulomb": 1.0}, "one number a joint"),
        ({"transition_velocity": 0.0}, "transition_velocity"),
        ({"stribeck_velocity": -1.0}, "stribeck_velocity"),
    ],
)
def test_friction_that_gives_power_or_has_no_shape_is_refused(change: dict[str, object], message: str) -> None:
    good = {"coulomb": np.array([0.8, 0.8]), "viscous": np.array([1.0, 1.0])}
    with pytest.raises(InputError, match=message):
        Friction(**{**good, **change})  # type: ignore[arg-type]
