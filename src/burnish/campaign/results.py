"""What is kept of each episode, and the file to which it is appended: a campaign that was cut off goes on there."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from burnish.campaign.draw import draw
from burnish.campaign.episode import Log, run
from burnish.campaign.judge import LIMITS, Verdict, judge, load_limits
from burnish.errors import InputError
from burnish.runtime.limits import Limits

PACKAGE = Path(__file__).parent.parent
DECIDES = ("campaign", "control", "model", "polish", "runtime", "sim", "surface", "teleop", "trajectory", "assets")
"""Folders of the package on which the result of an episode depends."""
PACKAGES = ("burnish", "mujoco", "pin", "numpy", "scipy", "ruckig")


@dataclass(frozen=True, kw_only=True)
class Result:
    """One episode: what was drawn, what the supervisor said, and the judge's verdict."""

    episode: int
    task: str
    fault: str
    """Names of its faults with `` + `` between them; ``none``."""
    text: str
    """The same in words, with what was drawn."""
    rate: float
    """[Hz]"""
    seconds: float
    """Virtual time [s]."""
    urgency: str | None
    mode: str
    """Of the supervisor at the end."""
    cause: str | None
    """That it gave."""
    trouble: str | None
    """Exception of the law, or of the simulation."""
    verdict: Verdict

    @classmethod
    def of(cls, log: Log, verdict: Verdict) -> Result:
        """From the log of an episode."""
        kept = {each.name for each in fields(cls)} & log.header.keys()
        return cls(**{name: log.header[name] for name in kept}, seconds=float(log.columns["t"][-1]), verdict=verdict)

    @classmethod
    def from_json(cls, line: str) -> Result:
        """From a line of the file."""
        values = json.loads(line)
        return cls(**(values | {"verdict": Verdict(**values["verdict"])}))

    def to_json(self) -> str:
        """As a line of the file."""
        return json.dumps(asdict(self), allow_nan=False)

    @property
    def kinds(self) -> list[str]:
        """Names of its faults, or ``none``."""
        return self.fault.split(" + ")

    @property
    def false_trip(self) -> bool:
        """Whether the arm was stopped though nothing was wrong."""
        return self.fault == "none" and self.verdict.stopped_at is not None

    @property
    def failed(self) -> bool:
        """Whether the simulation itself gave up."""
        return self.trouble is not None and self.trouble.startswith("simulation")


def run_episode(seed: int, number: int, *, nominal: bool) -> tuple[Result, Log]:
    """Draw an episode, run it and have it judged."""
    log = run(draw(seed, number, nominal=nominal))
    return Result.of(log, judge(log.columns, log.header, load_limits())), log


def run_batch(seed: int, numbers: Iterable[int], *, nominal: bool) -> list[Result]:
    """Episodes one after the other; what a process of the campaign does at a time."""
    return [run_episode(seed, number, nominal=nominal)[0] for number in numbers]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything that decides the results of a campaign but the number of its episodes."""

    seed: int
    nominal: bool
    limits: str
    """Hash of the supervisor's limits."""
    judge: str
    """Hash of the judge's."""
    source: str
    """Hash of the parts of the package that matter."""
    versions: dict[str, str]

    @classmethod
    def now(cls, seed: int, *, nominal: bool) -> Settings:
        """Those of this program."""
        return cls(
            seed=seed,
            nominal=nominal,
            limits=Limits.jaco2().hash,
            judge=hashlib.sha256(LIMITS.read_bytes()).hexdigest(),
            source=_source_hash(),
            versions={name: version(name) for name in PACKAGES},
        )


class Store:
    """The folder of a campaign: ``settings.json`` and, a line an episode, ``episodes.jsonl``."""

    def __init__(self, folder: Path, settings: Settings) -> None:
        """Open a folder, new or of the same campaign.

        Raises:
            InputError: if it is of another campaign, or damaged.
        """
        self._path = folder / "episodes.jsonl"
        self.results: dict[int, Result] = {}
        known = folder / "settings.json"
        if known.exists():
            self._check(known, settings)
            self.read()
        folder.mkdir(parents=True, exist_ok=True)
        known.write_text(json.dumps(asdict(settings), indent=2) + "\n", encoding="utf-8")

    def add(self, results: Iterable[Result]) -> None:
        """Keep these, on the disk before this returns."""
        new = list(results)
        with self._path.open("a", encoding="utf-8") as file:
            file.writelines(result.to_json() + "\n" for result in new)
            file.flush()
            os.fsync(file.fileno())
        self.results |= {result.episode: result for result in new}

    @staticmethod
    def _check(path: Path, settings: Settings) -> None:
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise InputError(f"{path} is no settings file of a campaign ({error}); choose another folder") from None
        wanted = asdict(settings)
        differ = [name for name in wanted if not isinstance(found, dict) or found.get(name) != wanted[name]]
        if differ:
            name = differ[0]
            before = found.get(name) if isinstance(found, dict) else None
            raise InputError(
                f"{path.parent} holds a campaign with {name} {str(before)[:80]}; expected {str(wanted[name])[:80]}. "
                "Choose another folder with --out"
            )

    def read(self) -> None:
        """Take what is on the disk, also after an `add` that was interrupted; a last line that was cut off is dropped.

        Raises:
            InputError: if it is damaged.
        """
        if not self._path.exists():
            return
        data = self._path.read_bytes()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):
            with self._path.open("r+b") as file:
                file.truncate(whole)
        for number, line in enumerate(data[:whole].splitlines(), 1):
            try:
                result = Result.from_json(line.decode())
            except (ValueError, TypeError, KeyError) as error:
                raise InputError(f"{self._path}, line {number} is damaged ({error}); choose another folder") from None
            self.results[result.episode] = result


def save_log(path: Path, log: Log) -> None:
    """The raw log as an ``.npz``: its columns, and the header as JSON text."""
    with path.open("wb") as file:
        columns: dict[str, Any] = {"header": np.array(json.dumps(log.header))} | log.columns
        np.savez_compressed(file, **columns)


def _source_hash() -> str:
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*")):
        place = path.relative_to(PACKAGE)
        if path.suffix in (".py", ".json", ".urdf") and (len(place.parts) == 1 or place.parts[0] in DECIDES):
            digest.update(str(place).encode() + path.read_bytes())
    return digest.hexdigest()
