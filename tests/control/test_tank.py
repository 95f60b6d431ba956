from __future__ import annotations

import numpy as np
import pytest

from burnish.control.tank import LOW, EnergyTank
from burnish.errors import InputError


def test_full_tank_scales_nothing() -> None:
    assert EnergyTank(capacity=0.3).share == 1.0


def test_tank_takes_no_more_than_it_holds() -> None:
    tank = EnergyTank(capacity=0.3)
    tank.add(5.0)
    assert tank.level == 0.3


def test_share_fades_to_nothing_without_a_jump() -> None:
    tank = EnergyTank(capacity=0.3)
    shares = []
    for _ in range(400):
        shares.append(tank.share)
        tank.add(-1e-3)
    # A cycle of 1 mJ out of the low sixth of 0.3 J is a share of 0.02.
    assert np.abs(np.diff(shares)).max() == pytest.approx(1e-3 / (LOW * 0.3), abs=1e-9)
    assert shares[-1] == 0.0


def test_tank_pays_out_what_it_held_and_what_was_damped_and_no_more() -> None:
    rng = np.random.default_rng(1)
    for capacity in (0.05, 0.3, 2.0):
        tank = EnergyTank(capacity=capacity)
        paid = damped = 0.0
        # Asked for up to the low level in each cycle, mostly driving; now and then it is damped.
        for asked, loss in zip(
            rng.uniform(-0.3, 1.0, 5000) * LOW * capacity, rng.normal(0.0, 0.1, 5000) * LOW * capacity, strict=True
        ):
            share = tank.share
            tank.add(loss - share * asked)
            paid, damped = paid + share * asked, damped + max(loss, 0.0)
            assert tank.level >= 0.0
            assert paid <= capacity + damped + 1e-9


def test_filled_tank_forgets() -> None:
    tank = EnergyTank(capacity=0.3)
    tank.add(-0.3)
    tank.fill()
    assert tank.share == 1.0


@pytest.mark.parametrize("capacity", [0.0, -1.0, np.nan])
def test_tank_without_room_is_refused(capacity: float) -> None:
    with pytest.raises(InputError, match="capacity ="):
        EnergyTank(capacity=capacity)
