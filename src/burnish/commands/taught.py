"""What teaching and replaying are asked for, and what both need to know of a recording."""

from __future__ import annotations

import hashlib
import platform
from dataclasses import dataclass
from pathlib import Path

from burnish.commands.order import SENSES, Setting
from burnish.commands.work import model_hash, tool_hash, versions
from burnish.errors import RecordingError
from burnish.model.tool import PolishingTool
from burnish.polish.cellsim import check_size
from burnish.record.described import described, fingerprint
from burnish.surface import DistanceGrid
from burnish.teach.session import Session
from burnish.teach.simulated import Cell


@dataclass(frozen=True, kw_only=True)
class Place(Setting):
    """Where something is taught, or replayed."""

    def cell(self) -> Cell:
        """The simulated arm in front of this mould.

        Raises:
            InputError: if the mould cannot be read, or is out of the arm's reach.
        """
        mould, tool = self.part(), PolishingTool()
        check_size(mould, tool)
        return Cell.of(self.drawn_arm(), mould, DistanceGrid.of(mould), self.rate, SENSES[self.sensor], tool)

    def metadata(self, cell: Cell, session: Session) -> dict[str, str]:
        """What a reader of a recording needs to know of the arm, the mould and the laws."""
        return (
            self.as_metadata()
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
