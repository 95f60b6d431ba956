"""What ``burnish polish`` was asked for: everything that decides a simulated run."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from typing_extensions import Self

from burnish.errors import InputError, RecordingError
from burnish.polish.cellsim import JointFelt, WristFelt
from burnish.polish.recipe import Recipe
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.surface import Mould, bundled

ARMS = {"ideal": arms.ideal, "honest": arms.honest, "honest-stiff": arms.honest_stiff}
SENSES: dict[str, WristFelt | JointFelt] = {"wrist": WristFelt(), "joint": JointFelt()}
AUTO = "auto"
"""The unit is found from the size of the part, or stands in the file."""
UNITS = (AUTO, "mm", "m", "inch")
NUMBERS: dict[str, type[float] | type[int]] = {"force": float, "feed": float, "rate": float, "seed": int}
"""Which options are numbers."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The simulated arm and its mould, by the words of the command line; checked."""

    mould: str
    """Bundled name or path of a file."""
    unit: str
    """Unit of that file, or `AUTO`."""
    arm: str
    """Name of the simulated arm."""
    sensor: str
    """Name of what it feels with."""
    rate: float
    """Control rate [Hz]."""
    seed: int
    """Seed of all random errors."""

    def __post_init__(self) -> None:
        for name, known in (("arm", ARMS), ("sensor", SENSES), ("unit", UNITS)):
            if getattr(self, name) not in known:
                raise InputError(f"{name} {getattr(self, name)!r} is not known; expected {', '.join(known)}")
        if self.seed < 0:
            raise InputError(f"seed {self.seed} is negative; expected 0 or more")
        if not 50.0 <= self.rate <= 1000.0:
            raise InputError(f"rate {self.rate:g} Hz is out of range; expected 50 to 1000 Hz")

    @classmethod
    def recorded(cls, metadata: Mapping[str, str], mould: str | None, unit: str | None = None) -> Self:
        """From a recording. What it names is never used as a path: the file of a mould has to be given.

        Args:
            metadata: of the recording.
            mould: the file of a mould that is not bundled.
            unit: of that file; None for that of the recording.

        Raises:
            RecordingError: if something is missing or out of range.
        """
        missing = [field.name for field in fields(cls) if field.name not in metadata]
        if missing:
            raise RecordingError(f"the recording does not say its {', '.join(missing)}; it cannot be used")
        if mould is None and metadata["mould"] not in bundled.NAMES:
            raise RecordingError(
                f"the recording is of the mould {metadata['mould'][:80]!r}, which is not bundled; give its file "
                "with --mould"
            )
        given: dict[str, Any] = {field.name: metadata[field.name] for field in fields(cls)}
        if mould is not None:
            given |= {"mould": mould, "unit": unit or given["unit"]}
        try:
            given |= {name: number(given[name]) for name, number in NUMBERS.items() if name in given}
        except ValueError as error:
            raise RecordingError(f"an option in the recording is no number ({error}); it cannot be used") from None
        return cls(**given)

    def part(self) -> Mould:
        """The mould.

        Raises:
            MouldError: it cannot be worked.
        """
        return Mould.load(self.mould, named(self.unit))

    def drawn_arm(self) -> Arm:
        """The simulated arm of this seed."""
        return ARMS[self.arm](self.seed)

    def as_metadata(self) -> dict[str, str]:
        """Names and values, every number with all its digits."""
        return {field.name: str(getattr(self, field.name)) for field in fields(self)}


@dataclass(frozen=True, kw_only=True)
class Order(Setting):
    """The options of a job, checked, with what was left open filled in."""

    force: float
    """Contact force [N]."""
    feed: float
    """Speed over the surface [m/s]."""

    def __post_init__(self) -> None:
        Recipe(force=self.force, feed=self.feed)
        super().__post_init__()

    @classmethod
    def asked(cls, options: argparse.Namespace) -> Order:
        """From the command line; an arm has its own rate.

        Raises:
            InputError: if an option is out of range.
        """
        given = {field.name: getattr(options, field.name) for field in fields(cls)}
        if given["rate"] is None:
            given["rate"] = ARMS[options.arm](max(options.seed, 0)).rate
        return cls(**given)

    @property
    def recipe(self) -> Recipe:
        """What to do on the mould."""
        return Recipe(force=self.force, feed=self.feed)


def named(unit: str) -> str | None:
    """The unit of a mould's file, where one was named."""
    return None if unit == AUTO else unit
