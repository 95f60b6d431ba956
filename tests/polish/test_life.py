"""How long an abrasive lasts."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import InputError
from burnish.paths.stroke import Stroke
from burnish.polish.life import Abrasive
from burnish.polish.passes import Leg


def leg(length: float) -> Leg:
    x = np.linspace(0.0, length, 50)
    n = np.tile([0.0, 0.0, 1.0], (50, 1))
    path = Stroke(points=np.column_stack([x, 0 * x, 0 * x]), normals=n, feed=np.full(50, 0.02), force=np.full(50, 10.0))
    return Leg(number=1, stroke=1, path=path)


def test_work_of_friction_is_mu_force_way() -> None:
    abrasive = Abrasive(friction=0.3)
    abrasive.rub(2.0, 10.0)
    assert (abrasive.metres, abrasive.joules) == (2.0, pytest.approx(6.0))


def test_stroke_is_cut_where_the_abrasive_is_worn() -> None:
    abrasive = Abrasive(most_metres=1.0)
    abrasive.rub(0.7, 10.0)
    assert abrasive.lasts(leg(0.2)) == pytest.approx(0.2)
    assert abrasive.lasts(leg(0.5)) == pytest.approx(0.3)


def test_work_may_be_the_shorter_limit() -> None:
    # 0.3 × 10 N × 0.5 m = 1.5 J.
    assert Abrasive(most_metres=1.0, most_joules=1.5, friction=0.3).lasts(leg(0.8)) == pytest.approx(0.5)


def test_worn_abrasive_is_not_put_to_the_surface() -> None:
    assert Abrasive(most_metres=1.0, metres=0.995).lasts(leg(0.5)) == 0.0


def test_life_has_to_be_more_than_nothing() -> None:
    with pytest.raises(InputError, match="life is 0 m"):
        Abrasive(most_metres=0.0)
