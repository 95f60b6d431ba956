"""A reading that cannot be is refused."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest

from burnish.errors import InputError
from burnish.teleop.device import AT_REST, Reading

GOOD: dict[str, Any] = {"t": 0.0, "axes": AT_REST, "buttons": (), "age": 0.0}


def test_a_good_reading_is_taken() -> None:
    assert Reading(**GOOD).connected


@pytest.mark.parametrize(
    "wrong",
    [
        {"axes": (0.0,) * 5},
        {"axes": (1.0001, 0.0, 0.0, 0.0, 0.0, 0.0)},
        {"axes": (nan, 0.0, 0.0, 0.0, 0.0, 0.0)},
        {"t": inf},
        {"t": nan},
        {"age": -0.01},
        {"age": nan},
    ],
    ids=str,
)
def test_what_is_no_reading_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="expected"):
        Reading(**GOOD | wrong)
