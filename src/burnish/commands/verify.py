"""``burnish verify``: run a simulated recording again and say whether it comes out the same, bit by bit."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from burnish.commands import replay
from burnish.commands.course import Course
from burnish.commands.order import Order
from burnish.commands.progress import Progress
from burnish.commands.work import drive, model_hash, prepare, tool_hash, versions
from burnish.errors import RecordingError
from burnish.record.compare import Comparison, compare
from burnish.record.recorder import TOPICS, Recorder
from burnish.record.recording import Recording

EXACT, DIFFERENT = 0, 1


def run(options: argparse.Namespace) -> int:
    """Refuse what cannot come out the same; else run it again and compare."""
    recording = Recording(Path(options.recording))
    found = recording.metadata
    verb = found.get("verb", "unknown")
    if verb not in AGAIN:
        raise RecordingError(
            f"{recording.path} is of '{verb[:40]}'; only simulated runs of {' and '.join(AGAIN)} can be run again"
        )
    _same("the arm's model", found.get("model_sha256"), model_hash())
    for package, now in versions().items():
        _same(package, found.get(package), now)
    with Progress() as progress, TemporaryDirectory(prefix="burnish-verify-") as folder:
        progress.stage("reading the mould")
        again = Path(folder) / "again.mcap"
        metadata = AGAIN[verb](recording, options, progress, again)
        progress.stage("comparing")
        result = compare(recording, Recording(again))
    return _say(recording, metadata, result)


def _polish(recording: Recording, options: argparse.Namespace, progress: Progress, again: Path) -> Mapping[str, str]:
    """Run a polishing job again; returns its metadata."""
    found = recording.metadata
    course = Course.recorded(found, recording.path.parent)
    _same("the tool", found.get("tool_sha256"), tool_hash(None if course is None else course.recipe.tool))
    order = Order.recorded(found, options.mould)
    mould = order.part()
    _same(f"the mould {mould.name}", found.get("mould_sha256"), mould.sha256)
    work = prepare(order, mould, progress, course)
    interrupted = recording.ending.get("interrupted_after", "")
    # Of a recording that was cut off no more has to be run again than it has.
    enough = sum(map(len, recording.blocks())) if _cut(recording) else None
    abandoned = recording.ending.get("abandoned_after", "")
    drive(
        work,
        again,
        progress,
        lambda count: str(count) == interrupted or count == enough,
        gone=lambda count: str(count) == abandoned,
    )
    return work.metadata()


def _replay(recording: Recording, options: argparse.Namespace, progress: Progress, again: Path) -> Mapping[str, str]:
    """Run a replay again, with the same keys after the same cycles; returns its metadata."""
    if options.taught is None:
        raise RecordingError(f"{recording.path} is a replay; give the file that was replayed with --taught")
    found = recording.metadata
    _same("the tool", found.get("tool_sha256"), tool_hash())
    asked = replay.recorded(found, Path(options.taught), options.mould, found.get("unit", "mm"))
    stage = replay.prepare(asked)
    _same(f"the mould {stage.cell.mould.name}", found.get("mould_sha256"), stage.cell.mould.sha256)
    keys, interrupted_after, abandoned_after = replay.script_of(recording)
    progress.stage("replaying")
    metadata = stage.metadata()
    with Recorder(again, joint_names=stage.rig.model.joint_names, metadata=metadata) as recorder:
        replay.seated(stage, recorder).drive(keys, interrupted_after, abandoned_after)
    return metadata


AGAIN: dict[str, Callable[[Recording, argparse.Namespace, Progress, Path], Mapping[str, str]]] = {
    "polish": _polish,
    "replay": _replay,
}
"""Verb to what runs it again."""


def _cut(recording: Recording) -> bool:
    """Whether the run went on after its recording ended; such a one is compared as far as it goes."""
    return recording.mended or "outcome" not in recording.ending


def _same(what: str, recorded: str | None, now: str) -> None:
    """Refuse a recording of something else, naming both."""
    if recorded != now:
        was = "nothing" if recorded is None else repr(recorded[:64])
        raise RecordingError(
            f"the recording is not of this: {what} is {now!r} here, the recording has {was}; "
            "verify it with what it was recorded with"
        )


def _say(recording: Recording, now: Mapping[str, str], result: Comparison) -> int:
    """The outcome, a line a topic where something differs."""
    recorded, again = result.lengths
    cut = _cut(recording)
    if not result.first and (recorded == again or (cut and recorded < again)):
        rest = "; the recording was cut off there" if cut else ""
        print(f"Bit-exact: {recorded} cycles, {len(TOPICS)} topics{rest}.")
        return EXACT
    print(f"Not exact: {min(result.lengths)} cycles compared.")
    for name in ("law", "travel", "limits"):
        was = recording.metadata.get(name, "nothing")
        if was != now[name]:
            # Of whatever length and with whatever characters it came.
            print(f"  {name}: differs; recorded {was[:2000]!a}")
            print(f"  {' ' * len(name)}  here     {now[name]!a}")
    for topic in TOPICS:
        place = result.first.get(topic)
        if place is None:
            print(f"  {topic}: exact")
            continue
        one, other = place.values
        print(
            f"  {topic}: differs from cycle {place.cycle} on (t = {place.t:.3f} s): {place.name} is {one!r} in the "
            f"recording, {other!r} now{', ' + place.unit if place.unit else ''}"
        )
    for name, most in result.largest.items():
        print(f"  largest difference of {name}: {most:.3g}")
    if recorded != again and not cut:
        print(f"  the recording has {recorded} cycles, the run {again}")
    return DIFFERENT
