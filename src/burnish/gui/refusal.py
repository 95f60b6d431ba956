"""A refusal in plain words, and where on the part it is."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from burnish.core import Array, read_only
from burnish.polish.cell import Placement

NUMBER = r"(-?\d+(?:\.\d+)?)"
ON_MOULD = re.compile(
    rf"^(?P<what>.*?) at \({NUMBER}, {NUMBER}, {NUMBER}\) mm of the mould, {NUMBER} mm along: (?P<why>.*)$"
)
AT_BASE = re.compile(rf"\({NUMBER}, {NUMBER}, {NUMBER}\) m in the wanted direction")


@dataclass(frozen=True, kw_only=True)
class Refusal:
    """Why a plan cannot be done."""

    why: str
    """What was found and what was expected, without the place."""
    remedy: str = ""
    """What to do about it."""
    where: str = ""
    """Which piece of the way, in words; empty where none is named."""
    at: Array | None = None
    """The place, mould frame [m], (3,); None where the refusal names none."""

    @property
    def sentence(self) -> str:
        """All of it in one line."""
        place = f"{self.where}: " if self.where else ""
        return f"{place}{self.why}" + (f" What helps: {self.remedy}" if self.remedy else "")


def explained(message: str, placement: Placement | None = None) -> Refusal:
    """The refusal of an error's message.

    Args:
        message: of a `BurnishError`.
        placement: where the mould stands, for places that are told in the base frame.
    """
    found = ON_MOULD.match(message)
    if found is not None:
        x, y, z, along = (float(number) for number in found.groups()[1:5])
        why, remedy = _parted(found["why"])
        where = f"{found['what'][:1].upper()}{found['what'][1:]}, {along:.0f} mm along"
        return Refusal(why=why, remedy=remedy, where=where, at=read_only(1e-3 * np.array([x, y, z])))
    why, remedy = _parted(message)
    found = AT_BASE.search(message)
    if found is None or placement is None:
        return Refusal(why=why, remedy=remedy)
    at = placement.R.T @ (np.array([float(number) for number in found.groups()]) - placement.p)
    return Refusal(why=why, remedy=remedy, at=read_only(at))


def _parted(text: str) -> tuple[str, str]:
    """What is wrong, and what to do: the last sentence, or what follows the last colon or semicolon of one sentence."""
    text = text.strip().rstrip(".")
    cut = max(text.rfind(". "), text.rfind("; "))
    if cut < 0 or text[cut + 2 :].startswith("expected"):
        return _sentence(text), ""
    return _sentence(text[:cut]), _sentence(text[cut + 2 :])


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
