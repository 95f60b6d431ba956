"""Stiffness and height of the contact, from pass to pass."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.polish.drift import Drift


def passed(drift: Drift, number: int, stiffness: float, sunk: float = 0.0) -> None:
    rng = np.random.default_rng(number)
    for leg in range(3):
        for force in np.linspace(0.0, 10.0, 40):
            noise = 1e-5 * rng.normal()
            drift.pressed(number, leg, 1e-4 * leg - force / stiffness + noise, force + 0.05 * rng.normal())
    for _ in range(200):
        drift.rubbed(number, -10.0 / stiffness - sunk + 2e-5 * rng.normal())


def test_stiffness_is_the_slope_of_force_against_deflection() -> None:
    drift = Drift()
    passed(drift, 1, 10.7e3)
    # 0.05 N of noise on a ramp of 10 N.
    assert drift.stiffness(1) == pytest.approx(10.7e3, rel=0.03)


def test_contact_that_stays_what_it_was_raises_no_warning() -> None:
    drift = Drift()
    for number in (1, 2, 3):
        passed(drift, number, 10.7e3)
    assert drift.warnings() == []


def test_softer_mount_and_worn_tip_are_said() -> None:
    drift = Drift()
    passed(drift, 1, 10.7e3)
    passed(drift, 2, 7.0e3)
    passed(drift, 3, 10.7e3, sunk=0.6e-3)
    said = drift.warnings()
    assert "pass 2: the contact yields at 7" in said[0]
    assert any("pass 3: the contact lies 0.6 mm lower" in sentence for sentence in said)
