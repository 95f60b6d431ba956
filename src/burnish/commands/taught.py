"""What teaching and replaying are asked for, and what both need to know of a recording."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from burnish.commands.order import ARMS, SENSES, UNITS, named
from burnish.commands.work import model_hash, tool_hash, versions
from burnish.errors import InputError, RecordingError
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import check_size
from burnish.record.described import described, fingerprint
from burnish.surface import DistanceGrid, Mould, bundled
from burnish.teach.session import Session
from burnish.teach.simulated import Cell


@dataclass(frozen=True, kw_only=True)
class Place:
    """The simulated arm and its mould, by the words of the command line; checked."""

    mould: str
    """Bundled name or path of a mesh."""
    unit: str
    """Unit of that file."""
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
    def recorded(cls, metadata: Mapping[str, str], mould: str | None, unit: str) -> Place:
        """From a recording. What it names is never used as a path: the file of a mould has to be given.

        Raises:
            RecordingError: if something is missing or out of range.
        """
        missing = [field.name for field in fields(cls) if field.name not in metadata]
        if missing:
            raise RecordingError(f"the recording does not say its {', '.join(missing)}; it cannot be used")
        if mould is None and metadata["mould"] not in bundled.NAMES:
            raise RecordingError(
                f"the recording is of the mould {metadata['mould'][:80]!r}, which is not bundled; give its STL file "
                "with --mould"
            )
        try:
            return cls(
                mould=metadata["mould"] if mould is None else mould,
                unit=metadata["unit"] if mould is None else unit,
                arm=metadata["arm"],
                sensor=metadata["sensor"],
                rate=float(metadata["rate"]),
                seed=int(metadata["seed"]),
            )
        except ValueError as error:
            raise RecordingError(f"an option in the recording is no number ({error}); it cannot be used") from None

    def cell(self) -> Cell:
        """The simulated arm in front of this mould.

        Raises:
            InputError: if the mould cannot be read, or is out of the arm's reach.
        """
        mould, tool = Mould.load(self.mould, named(self.unit)), PolishingTool()
        check_size(mould, tool)
        arm = ARMS[self.arm](self.seed)
        return Cell.of(arm, mould, DistanceGrid.of(mould), self.rate, SENSES[self.sensor], tool)

    def metadata(self, cell: Cell, session: Session) -> dict[str, str]:
        """What a reader of a recording needs to know of the arm, the mould and the laws."""
        return (
            {field.name: str(getattr(self, field.name)) for field in fields(self)}
            | {"mould": cell.mould.name, "python": platform.python_version()}
            | versions()
            | {"model_sha256": model_hash(), "tool_sha256": tool_hash(), "mould_sha256": cell.mould.sha256}
            | {"travel": described(session.travel), "travel_sha256": fingerprint(session.travel)}
            | {"limits": described(session.rig.supervisor.limits)}
            | {"limits_sha256": fingerprint(session.rig.supervisor.limits)}
        )


def file_hash(path: Path) -> str:
    """SHA-256 of a file.

    Raises:
        RecordingError: if it cannot be read.
    """
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise RecordingError(f"{path} cannot be read ({error.strerror}); expected a recording") from None
