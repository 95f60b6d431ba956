"""From the folder of a job to a row: its recordings, figures, reports and journal."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

from burnish.errors import InputError, RecordingError
from burnish.library.cards import scalar
from burnish.library.readers import LARGEST_RECORDING, now
from burnish.library.rows import LONGEST_NAME, RunRow, Scalar, Stored, identity, one_line
from burnish.library.storage import Source, read_bounded
from burnish.polish import journal
from burnish.record.recording import Recording
from burnish.record.recover import recover

LARGEST = 256 * 2**20
"""Of a report or a journal [B]."""
FIGURES = 2**20
"""Of a file of figures [B]."""
RECORDINGS = re.compile(r"run(?:-(\d{1,6}))?\.mcap")
"""``run.mcap``, and a further one each time that the job was gone on with."""
PAGES = (("report.html", "report"), ("part.html", "part"))
ENDS = ("done", "stopped", "interrupted", "paused", "cancelled")
LOST = "lost: the program ended before it could say how"
CAMPAIGN = "campaign"


def read_run(folder: Path, staged: Path) -> RunRow:
    """A job of ``burnish polish``, ``teach``, ``replay``, ``teleop`` or ``campaign``, whole or cut off.

    Args:
        folder: that the job wrote.
        staged: where its files are copied to.

    Raises:
        InputError: if it holds no job, or a file of it is not what its name says.
    """
    if not folder.is_dir():
        raise InputError(f"{folder} is no folder; expected that of a job, with its run.mcap")
    where = str(folder.resolve())
    if not where.isprintable():
        raise InputError(f"the folder {where!r} has a name that cannot be shown; expected letters: rename it")
    return _campaign(folder, staged) if (folder / "campaign.json").exists() else _job(folder, staged)


def _job(folder: Path, staged: Path) -> RunRow:
    """A job with recordings."""
    recorded = list(_recordings(folder, staged))
    if not recorded:
        raise InputError(f"{folder} holds no run.mcap and no campaign.json; expected the folder of a job")
    last = recorded[-1][1]
    files = [stored for stored, _ in recorded]
    metrics = _metrics(folder, staged, files)
    outcome = _outcome(last, metrics, folder, staged, files)
    about = {name: one_line(value, LONGEST_NAME) for name, value in last.metadata.items()}
    return RunRow(
        id=identity(RunRow, str(folder.resolve()), files[0].sha256),
        name=folder.resolve().name,
        created=now(),
        files=(*files, *_pages(folder, staged)),
        verb=about.get("verb", ""),
        mould=about.get("mould", ""),
        mould_sha256=about.get("mould_sha256", ""),
        arm=about.get("arm", ""),
        sensor=about.get("sensor", ""),
        ended=_ended(outcome),
        outcome=outcome,
        duration=_seconds(metrics, "duration_s"),
        folder=str(folder.resolve()),
        metrics=metrics,
    )


def _campaign(folder: Path, staged: Path) -> RunRow:
    """A campaign: it has figures and pages, and no recording."""
    files = [
        Source(called=str(path), content=path).copied(staged, role, ".json", FIGURES * 16)
        for path, role in ((_own(folder, "campaign.json"), "metrics"), (_own(folder, "settings.json"), "settings"))
    ]
    found = _json(folder / "campaign.json", FIGURES * 16)
    metrics = _scalars(found)
    outcome = "interrupted" if found.get("interrupted") is True else "done"
    return RunRow(
        id=identity(RunRow, str(folder.resolve()), files[1].sha256),
        name=folder.resolve().name,
        created=now(),
        files=(*files, *_pages(folder, staged)),
        verb=CAMPAIGN,
        mould="",
        mould_sha256="",
        arm="",
        sensor="",
        ended=outcome,
        outcome=outcome,
        duration=3600.0 * _seconds(metrics, "virtual_hours"),
        folder=str(folder.resolve()),
        metrics=metrics,
    )


def _recordings(folder: Path, staged: Path) -> Iterator[tuple[Stored, Recording]]:
    """The recordings in their order; one that was cut off is mended on its way in."""
    found = [(int(match[1] or 1), path) for path in folder.iterdir() if (match := RECORDINGS.fullmatch(path.name))]
    for number, path in sorted(found):
        role = "recording" if number == 1 else f"recording-{number}"
        source = Source(called=str(path), content=_own(folder, path.name))
        stored = source.copied(staged, role, ".mcap", LARGEST_RECORDING)
        with source.reading(stored, staged) as copy:
            try:
                yield stored, Recording(copy)
            except RecordingError:
                mended = staged / f"mended-{number}"
                recover(copy, mended)
                copy.unlink()
                whole = Source(called=str(path), content=mended).copied(staged, role, ".mcap", LARGEST_RECORDING)
                mended.unlink()
                yield whole, Recording(staged / PurePath(whole.path).name)


def _metrics(folder: Path, staged: Path, files: list[Stored]) -> dict[str, Scalar]:
    """The figures; none where the job was cut off before it wrote them."""
    path = folder / "metrics.json"
    if not path.exists():
        return {}
    files.append(Source(called=str(path), content=_own(folder, path.name)).copied(staged, "metrics", ".json", FIGURES))
    return _scalars(_json(path, FIGURES))


def _outcome(last: Recording, metrics: Mapping[str, Scalar], folder: Path, staged: Path, files: list[Stored]) -> str:
    """How it ended, in words: as the last recording says, else the figures."""
    path = folder / journal.NAME
    if path.exists():
        journal.read(_own(folder, path.name))
        files.append(Source(called=str(path), content=path).copied(staged, "journal", ".jsonl", LARGEST))
    return one_line(str(last.ending.get("outcome") or metrics.get("outcome") or LOST), 500)


def _ended(outcome: str) -> str:
    word = outcome.split()[0].rstrip(":").casefold()
    return word if word in ENDS else "lost"


def _pages(folder: Path, staged: Path) -> list[Stored]:
    """The reports that there are."""
    return [
        Source(called=str(folder / name), content=_own(folder, name)).copied(staged, role, ".html", LARGEST)
        for name, role in PAGES
        if (folder / name).exists()
    ]


def _own(folder: Path, name: str) -> Path:
    """A file of the folder itself: a link could lead anywhere."""
    path = folder / name
    if path.is_symlink():
        raise InputError(f"{path} is a link; expected a file of the job's own folder")
    return path


def _json(path: Path, most: int) -> Mapping[str, Any]:
    """A JSON file with names and values."""
    try:
        found = json.loads(read_bounded(path, most))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is no JSON ({str(error)[:100]}); expected the figures of a job") from None
    if not isinstance(found, dict):
        raise InputError(f"{path} holds no names and values; expected the figures of a job")
    return found


def _scalars(found: Mapping[str, Any]) -> dict[str, Scalar]:
    """The plain figures of a file."""
    metrics: dict[str, Scalar] = {}
    for name, value in found.items():
        if isinstance(value, int | float | str | bool):
            try:
                figure = one_line(value, 500) if isinstance(value, str) else scalar(value)
            except ValueError as error:
                raise InputError(f"the figure {name[:40]!r} cannot be used ({error}); run the job again") from None
            metrics[one_line(name, LONGEST_NAME)] = figure
    return metrics


def _seconds(metrics: Mapping[str, Scalar], name: str) -> float:
    value = metrics.get(name, 0.0)
    return float(value) if isinstance(value, int | float) else 0.0
