"""What one unit of a file is worth when the file does not say."""

from __future__ import annotations

import numpy as np
import pytest

from burnish.errors import MouldError
from burnish.surface.units import found_unit


@pytest.mark.parametrize(
    ("longest", "unit"),
    [(1000.0, "mm"), (10.0, "mm"), (9.0, "inch"), (1.1, "inch"), (0.39, "m"), (0.01, "m"), (0.001, "mm"), (5e3, "mm")],
)
def test_unit_is_the_one_that_fits_and_anything_but_mm_is_said(longest: float, unit: str) -> None:
    found, said = found_unit("part.stl", np.array([longest, longest / 2, longest / 4]))
    assert found == unit
    assert bool(said) == (unit != "mm")


def test_sentence_names_the_size_that_follows() -> None:
    assert "taken as inch: 50.8 × 25.4 × 12.7 mm" in found_unit("part.stl", np.array([2.0, 1.0, 0.5]))[1][0]


@pytest.mark.parametrize("longest", [0.4, 0.5, 1.0])
def test_size_that_two_units_fit_is_refused(longest: float) -> None:
    with pytest.raises(MouldError, match="may be m or inch: give the unit"):
        found_unit("part.stl", np.array([longest, longest, 0.1]))
