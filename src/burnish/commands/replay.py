"""``burnish replay``: hold home, go to the ready pose, play what was taught as often as asked, go home."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from burnish.analysis.metrics import Scalar, write_metrics
from burnish.commands.entered import entered
from burnish.commands.keys import typed_keys
from burnish.commands.live import watched
from burnish.commands.options import output_folder, relative
from burnish.commands.order import ARMS
from burnish.commands.screen import Screen
from burnish.commands.seat import Script, Seat, needs_somebody, paced
from burnish.commands.signals import ended_by_signals
from burnish.commands.taught import Place, file_hash
from burnish.commands.taught_report import CLEANED, REPLAYED, cleaned_figure, replayed_figure, write_page
from burnish.commands.work import model_hash, tool_hash, versions
from burnish.core import Sample
from burnish.errors import InputError, RecordingError
from burnish.record.described import described, fingerprint
from burnish.record.poses_file import read_poses
from burnish.record.recorder import Recorder
from burnish.record.recording import Recording
from burnish.runtime.loop import Rig
from burnish.sim.robot import SimRobot
from burnish.teach.cleanup import Taught, cleaned
from burnish.teach.demonstration import Demonstration, check_same
from burnish.teach.execute import Execute, HoldForce
from burnish.teach.judge import Followed, ReplayLog, as_cleaned, followed, seen_from
from burnish.teach.replay import SPEED_FACTOR, Track
from burnish.teach.session import Key, Session
from burnish.teach.simulated import Cell, moved_placement

DONE, STOPPED, INTERRUPTED = 0, 3, 130
HELD_LINE = (
    "force {force_rms_N:.2f} N RMS off what was shown, {position_rms_mm:.2f} mm RMS off the path, {repeats} repeats; "
    "all simulated"
)
MOST_REPEATS = 1000
FURTHEST, MOST_TURN = 0.3, 1.0
"""How far a mould may have been moved [m], and turned [rad]; further is another cell."""
STILL = (0.0,) * 6


@dataclass(frozen=True, kw_only=True)
class Replay:
    """What is replayed, how, and where; checked."""

    path: Path
    """A recording of ``burnish teach``, or poses."""
    place: Place
    """Arm and mould."""
    repeats: int
    """How often."""
    speed: float
    """Times as fast as shown."""
    open_loop: bool
    """The poses alone."""
    mould_at: tuple[float, ...]
    """Shift [m] and rotation vector [rad] of the mould since, base axes."""

    def __post_init__(self) -> None:
        if not 1 <= self.repeats <= MOST_REPEATS:
            raise InputError(f"--repeats {self.repeats} is out of range; expected 1 to {MOST_REPEATS}")
        if not SPEED_FACTOR[0] <= self.speed <= SPEED_FACTOR[1]:
            low, high = SPEED_FACTOR
            raise InputError(f"--speed {self.speed:g} is out of range; expected {low:g} to {high:g}")
        shift, turn = np.linalg.norm(self.mould_at[:3]), np.linalg.norm(self.mould_at[3:])
        if len(self.mould_at) != 6 or not (shift <= FURTHEST and turn <= MOST_TURN):
            raise InputError(
                f"--mould-at moves the mould by {shift:.3g} m and {turn:.3g} rad; expected at most {FURTHEST:g} m and "
                f"{MOST_TURN:g} rad"
            )
        if self.is_poses and not self.open_loop:
            raise InputError(
                f"{self.path} holds poses and no force; give --open-loop, or a recording of 'burnish teach'"
            )

    @property
    def is_poses(self) -> bool:
        """Whether it is a text of poses."""
        return self.path.suffix == ".txt"

    def metadata(self) -> dict[str, str]:
        """How it was replayed, with all digits, and of what."""
        return {
            "verb": "replay",
            "repeats": str(self.repeats),
            "speed": repr(self.speed),
            "open_loop": str(self.open_loop),
            "mould_at": " ".join(map(repr, self.mould_at)),
            "taught_sha256": file_hash(self.path),
        }


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A replay made ready; nothing has moved."""

    replay: Replay
    """What was asked for."""
    cell: Cell
    """The arm and its mould, moved."""
    rig: Rig
    """The arm."""
    robot: SimRobot
    """Its simulation."""
    taught: Taught | None
    """What was taught; None for poses and open loop."""
    session: Execute
    """What plays it."""
    log: ReplayLog
    """Where the reference was."""

    def metadata(self) -> dict[str, str]:
        """For the recording."""
        law = self.session.law if self.taught is not None else self.cell.operator_law()
        return (
            self.replay.metadata()
            | self.replay.place.metadata(self.cell, self.session)
            | {"law": described(law), "law_sha256": fingerprint(law)}
        )

    def note(self, sample: Sample) -> None:
        """Log a cycle."""
        session, along = self.session, self.session.along
        on = session.phase == "pass" and along is not None
        s = along.s if on and along is not None and along.settled >= along.track.settle else -1.0
        paused = along is not None and along.paused
        self.log.add(sample, session.repeat if on and not paused else 0, session.piece, s)


def run(options: argparse.Namespace) -> int:
    """Replay, and write ``run.mcap``, ``metrics.json`` and ``report.html``; nothing when it is refused."""
    needs_somebody(options.yes or options.live is not None)
    stage = prepare(asked(options))
    folder = output_folder(options.out, "replay")
    pace = options.pace if options.pace is not None else 0.0 if options.yes else 1.0
    paced(stage.rig, stage.robot, pace)
    with ExitStack() as stack:
        live = stack.enter_context(watched(options))
        folder.mkdir(parents=True, exist_ok=True)
        names = stage.rig.model.joint_names
        recorder = stack.enter_context(Recorder(folder / "run.mcap", joint_names=names, metadata=stage.metadata()))
        seat = seated(stage, recorder)
        seat.live = live
        stack.enter_context(ended_by_signals(seat.interrupt))
        if options.yes:
            seat.by_itself = _by_itself
        elif options.live is None:
            seat.typed = stack.enter_context(typed_keys(None))
            seat.screen = stack.enter_context(Screen())
        wall = seat.drive()
    return _finish(seat, stage, folder, wall)


def asked(options: argparse.Namespace) -> Replay:
    """From the command line; what was not said is as it was taught.

    Raises:
        InputError: if an option is out of range, or the recording is of another arm, tool or mould.
    """
    path = Path(options.recording)
    if path.suffix == ".txt":
        arm, seed = options.arm or "honest", options.seed or 0
        place = Place(
            mould=options.mould or "dome",
            unit=options.unit,
            arm=arm,
            sensor=options.sensor or "wrist",
            rate=ARMS[arm](max(seed, 0)).rate if options.rate is None else options.rate,
            seed=seed,
        )
    else:
        recorded = Place.recorded(Recording(path).metadata, options.mould, options.unit)
        given = {name: getattr(options, name) for name in ("arm", "sensor", "rate", "seed")}
        place = replace(recorded, **{name: value for name, value in given.items() if value is not None})
    return Replay(
        path=path,
        place=place,
        repeats=options.repeats,
        speed=options.speed,
        open_loop=options.open_loop,
        mould_at=STILL if options.mould_at is None else tuple(options.mould_at),
    )


def recorded(metadata: Mapping[str, str], taught: Path, mould: str | None, unit: str) -> Replay:
    """From a recording of a replay, and the file that it was a replay of.

    Raises:
        RecordingError: if something is missing or out of range, or that is another file.
    """
    was, now = metadata.get("taught_sha256", "nothing"), file_hash(taught)
    if was != now:
        raise RecordingError(
            f"{taught} is not what was replayed: its hash is {now[:16]!r}, expected {was[:16]!r}; give that"
        )
    try:
        return Replay(
            path=taught,
            place=Place.recorded(metadata, mould, unit),
            repeats=int(metadata.get("repeats", "")),
            speed=float(metadata.get("speed", "")),
            open_loop=metadata.get("open_loop") == "True",
            mould_at=tuple(float(word) for word in metadata.get("mould_at", "").split()),
        )
    except ValueError as error:
        raise RecordingError(f"the recording does not say how it was replayed ({error})") from None


def prepare(replay: Replay) -> Stage:
    """The session, checked against the recording.

    Raises:
        InputError: if it cannot be replayed here.
    """
    shift, turn = np.array(replay.mould_at[:3]), np.array(replay.mould_at[3:])
    home = replay.place.cell()
    cell = home.moved(shift, turn)
    rig, robot = cell.rig()
    taught = None
    session: Execute
    if replay.is_poses:
        poses = read_poses(replay.path)
        session = cell.open_loop(rig, Track.by_poses(poses, replay.speed), repeats=replay.repeats)
    else:
        recording = Recording(replay.path)
        check_same(recording, model=model_hash(), tool=tool_hash(), mould=cell.mould.sha256)
        demonstration = Demonstration.of(recording)
        if replay.open_loop:
            at = moved_placement(demonstration.placement, shift, turn)
            track = Track.by_time(demonstration, at, replay.speed)
            session = cell.open_loop(rig, track, repeats=replay.repeats)
        else:
            taught = cleaned(demonstration, cell.grid, cell.tool)
            session = cell.hold_force(rig, taught, repeats=replay.repeats, speed=replay.speed)
    return Stage(replay=replay, cell=cell, rig=rig, robot=robot, taught=taught, session=session, log=ReplayLog())


def seated(stage: Stage, recorder: Recorder) -> Seat:
    """The seat at it."""
    place = stage.replay.place
    return Seat(
        session=stage.session,
        robot=stage.robot,
        recorder=recorder,
        after=stage.note,
        title=f"replay on {stage.cell.mould.name}, simulated {place.arm} arm at {place.rate:g} Hz",
    )


def script_of(recording: Recording) -> tuple[Script, int | None, int | None]:
    """The keys of a recorded replay by their cycles, and the cycles after which it was interrupted, and abandoned.

    Raises:
        RecordingError: if it does not say them: then it was cut off.
    """
    if "keys" not in recording.ending:
        raise RecordingError(f"{recording.path} was cut off: the keys that were pressed are not in it; record it anew")
    known = {key.value: key for key in Key}
    script: dict[int, Key] = {}
    for word in recording.ending["keys"].split():
        count, _, name = word.partition(":")
        if not count.isdecimal() or len(count) > 12 or name not in known:
            raise RecordingError(f"{recording.path}: {word[:40]!r} is no cycle and key; the recording is damaged")
        script[int(count)] = known[name]
    ends = [recording.ending.get(name, "") for name in ("interrupted_after", "abandoned_after")]
    interrupted, abandoned = (int(after) if after.isdecimal() and len(after) <= 12 else None for after in ends)
    return script, interrupted, abandoned


def _by_itself(session: Session) -> Key | None:
    return Key.GO_ON if Key.GO_ON in session.waits_for else None


def judged(stage: Stage) -> Followed | None:
    """What came of the force and the path, by the true contact; None where there was none to hold."""
    session, truth = stage.session, stage.robot.truth
    held = (np.asarray(stage.log.repeat) > 0) & (np.asarray(stage.log.s) >= 0.0)
    if not isinstance(session, HoldForce) or not held.any():
        return None
    point = seen_from(np.asarray(truth.point), stage.cell.stands(), session.placement)
    shown = as_cleaned(session.taught, stage.cell.tool.tip_radius)
    return followed(stage.log, truth, point, session.taught.pieces, shown)


def _finish(seat: Seat, stage: Stage, folder: Path, wall: float) -> int:
    """Metrics, report and a few lines."""
    session, replay, outcome = stage.session, stage.replay, seat.outcome()
    force = np.asarray(stage.robot.truth.cycle_force())
    found = judged(stage)
    metrics: dict[str, Scalar] = {
        "outcome": outcome,
        "duration_s": stage.robot.time,
        "realtime_factor": stage.robot.time / wall,
        "cycles": len(stage.log.t),
        "late_cycles": stage.robot.late_cycles,
        "supervisor_events": int(session.rig.supervisor.tripped),
        "touched_N": float(force.max(initial=0.0)),
        "speed": replay.speed,
        "open_loop": replay.open_loop,
        "seed": replay.place.seed,
        "mould": stage.cell.mould.name,
        "arm": replay.place.arm,
        "sensor": replay.place.sensor,
        "rate_Hz": replay.place.rate,
    }
    figures = {}
    if found is not None:
        metrics |= found.figures()
        figures["What was held"] = (replayed_figure(found), REPLAYED)
    if stage.taught is not None:
        figures["What was taught, before and after"] = (
            cleaned_figure(stage.taught, stage.cell.tool.tip_radius),
            CLEANED,
        )
    write_metrics(folder / "metrics.json", metrics)
    about: dict[str, Scalar] = {**replay.metadata(), **versions()}
    write_page(folder / "report.html", f"Replayed on {stage.cell.mould.name}", outcome, figures, metrics, about)
    entered(folder, mould=replay.place.mould, unit=replay.place.unit)
    if seat.why != "SIGHUP":
        print(f"{outcome[:1].upper()}{outcome[1:]}.")
        if found is not None:
            print(HELD_LINE.format(**metrics))
        print(f"report: {relative(folder / 'report.html')}")
    if session.interrupted:
        return INTERRUPTED
    return STOPPED if session.rig.supervisor.tripped or session.failure else DONE
