"""What one unit of a file is worth, asked for or found out from the size of the part."""

from __future__ import annotations

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError

METRES_PER_UNIT = {"mm": 1e-3, "m": 1.0, "inch": 25.4e-3}
"""What one unit of the file may be worth [m]; most kinds of file do not say."""

SMALLEST_SIDE = 10e-3
"""Least length of the longer horizontal side [m]: below, a 15 mm tip has nothing to work on."""

LARGEST_SIDE = 1.0
"""Greatest length of any side [m]: beyond the reach of the arms that this is for."""


def check_unit(unit: str | None) -> None:
    """Refuse a unit that is none.

    Raises:
        MouldError: names those that are known.
    """
    if unit is not None and unit not in METRES_PER_UNIT:
        raise MouldError(f"the unit '{unit}' is not known; expected one of {', '.join(METRES_PER_UNIT)}")


def fits(sides: Array) -> bool:
    """Whether a bounding box with these sides [m], (3,), can be worked by an arm."""
    return bool(sides.max() <= LARGEST_SIDE and sides[:2].max() >= SMALLEST_SIDE)


def found_unit(source: str, sides: Array) -> tuple[str, tuple[str, ...]]:
    """The unit of a part whose file names none, and a sentence where it is not the usual one.

    Millimetres are taken wherever they fit. Of metres and inches only one may fit: a box of 0.5 may be half a
    metre or half an inch.

    Args:
        source: what a message calls the file.
        sides: of the bounding box, in the file's unit, (3,).

    Raises:
        MouldError: metres and inches both fit.
    """
    if fits(sides * METRES_PER_UNIT["mm"]):
        return "mm", ()
    fitting = [unit for unit in METRES_PER_UNIT if fits(sides * METRES_PER_UNIT[unit])]
    found = " × ".join(f"{side:.4g}" for side in sides)
    if len(fitting) > 1:
        raise MouldError(
            f"{source} measures {found} and names no unit; that is too small for mm and may be "
            f"{' or '.join(fitting)}: give the unit"
        )
    if not fitting:
        return "mm", ()
    size = " × ".join(f"{1e3 * METRES_PER_UNIT[fitting[0]] * side:.4g}" for side in sides)
    return fitting[0], (
        f"it measures {found} and names no unit; that cannot be mm and is taken as {fitting[0]}: {size} mm",
    )


def size_in_mm(sides: Array) -> str:
    """Sides [m], (3,), as a person reads them."""
    return " × ".join(f"{1e3 * side:.6g}" for side in np.asarray(sides))
