"""``burnish teach``: hold home, follow the operator, store what was shown, go home; in the order of thesis B."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from burnish.analysis.metrics import Scalar, write_metrics
from burnish.commands.entered import entered
from burnish.commands.keys import typed_keys
from burnish.commands.live import Alone, watched
from burnish.commands.options import output_folder, relative
from burnish.commands.order import ARMS
from burnish.commands.screen import Screen
from burnish.commands.seat import Seat, needs_somebody, paced
from burnish.commands.signals import ended_by_signals
from burnish.commands.station import MODES
from burnish.commands.taught import Place
from burnish.commands.taught_report import CLEANED, cleaned_figure, write_page
from burnish.commands.work import versions
from burnish.core import Source, ToolReference
from burnish.errors import BurnishError, InputError
from burnish.polish.cell import tool_down
from burnish.record.described import described, fingerprint
from burnish.record.recorder import Recorder
from burnish.record.recording import Recording
from burnish.runtime.loop import Rig
from burnish.runtime.operating import operator
from burnish.sim.robot import SimRobot
from burnish.teach.cleanup import Taught, cleaned
from burnish.teach.demonstration import STORED, Demonstration, placement_text, write_poses
from burnish.teach.hand import Hand
from burnish.teach.session import Key, Session
from burnish.teach.simulated import Cell
from burnish.teach.train import Train
from burnish.teleop.device import Device
from burnish.teleop.find import WORDS, open_device
from burnish.teleop.keyboard import Keyboard
from burnish.teleop.modes import Panel
from burnish.teleop.reference import Pace
from burnish.teleop.shaped import Shaped

DONE, STOPPED, INTERRUPTED = 0, 3, 130
HAND, JOG = "hand", "jog"
STORED_LINE = (
    "stored: {contacts} contacts, {path_length_m:.2f} m, {force_least_N:.1f} to {force_most_N:.1f} N; all simulated"
)


@dataclass(kw_only=True)
class Shower:
    """Who shows: a source of tool references, its mode, and whether it has come to its end."""

    source: Source[ToolReference]
    """Where the tool is moved to."""
    mode: Callable[[], str]
    """The mode that the operator is in."""
    ended: Callable[[], bool]
    """Whether nothing more will come."""
    name: str
    """What the operator commands with."""
    device: Device | None = None
    """To be left in the end; the hand is none."""


def run(options: argparse.Namespace) -> int:
    """Teach; write ``run.mcap``, ``metrics.json``, ``report.html``, ``desired_poses.txt``; nothing when refused."""
    needs_somebody(options.yes or options.live is not None)
    if options.device not in (HAND, JOG, *WORDS) and not Path(options.device).is_file():
        words = ", ".join((HAND, JOG, *WORDS))
        raise InputError(f"--device {options.device}: no such device or file; expected {words}, or a file")
    rate = ARMS[options.arm](max(options.seed, 0)).rate if options.rate is None else options.rate
    place = Place(
        mould=options.mould, unit=options.unit, arm=options.arm, sensor=options.sensor, rate=rate, seed=options.seed
    )
    folder = output_folder(options.out, "teach")
    cell = place.cell()
    rig, robot = cell.rig()
    paced(rig, robot, _pace(options))
    with ExitStack() as stack:
        live = stack.enter_context(watched(options))
        shower = _shower(options, cell, rig, robot, live)
        train = cell.train(rig, shower.source, shower.mode)
        metadata = {"verb": "teach"} | place.metadata(cell, train)
        metadata |= {"placement": placement_text(cell.placement), "device": shower.name}
        metadata |= {"law": described(train.operator_law), "law_sha256": fingerprint(train.operator_law)}
        if shower.device is not None:
            stack.enter_context(shower.device)
        folder.mkdir(parents=True, exist_ok=True)
        recorder = stack.enter_context(
            Recorder(folder / "run.mcap", joint_names=train.rig.model.joint_names, metadata=metadata)
        )
        seat = Seat(session=train, robot=robot, recorder=recorder, device=shower.name, mode=shower.mode, live=live)
        seat.title = f"teach on {cell.mould.name}, simulated {place.arm} arm at {rate:g} Hz"
        if options.yes:
            seat.by_itself = lambda session: _by_itself(session, shower)
        stack.enter_context(ended_by_signals(seat.interrupt))
        if not options.yes and options.live is None:
            seat.typed = _read_too(shower.device, stack.enter_context(typed_keys(shower.device)))
            seat.screen = stack.enter_context(Screen())
        wall = seat.drive()
        if train.stored is not None:
            recorder.end_with(**{STORED: f"{train.stored[0]} {train.stored[1]}"})
    return _finish(seat, train, cell, place, folder, wall)


def _finish(seat: Seat, train: Train, cell: Cell, place: Place, folder: Path, wall: float) -> int:
    """Clean up what was stored, and report it."""
    taught, trouble = None, ""
    if train.stored is not None:
        demonstration = Demonstration.of(Recording(folder / "run.mcap"))
        write_poses(folder / "desired_poses.txt", demonstration)
        try:
            taught = cleaned(demonstration, cell.grid, cell.tool)
        except BurnishError as error:
            # What was shown is kept; that it cannot be replayed with force is said.
            trouble = str(error)
    outcome = seat.outcome()
    metrics: dict[str, Scalar] = {
        "outcome": outcome,
        "duration_s": seat.robot.time,
        "realtime_factor": seat.robot.time / wall,
        "cycles": train.count,
        "late_cycles": seat.robot.late_cycles,
        "supervisor_events": int(train.rig.supervisor.tripped),
        "stored": train.stored is not None,
        "seed": place.seed,
        "mould": cell.mould.name,
        "arm": place.arm,
        "sensor": place.sensor,
        "rate_Hz": place.rate,
    }
    if taught is not None:
        metrics |= _figures(taught)
    write_metrics(folder / "metrics.json", metrics)
    figures = {} if taught is None else {"Before and after": (cleaned_figure(taught, cell.tool.tip_radius), CLEANED)}
    about: dict[str, Scalar] = {"device": seat.device, "law": described(train.operator_law), **versions()}
    write_page(folder / "report.html", f"Taught on {cell.mould.name}", outcome, figures, metrics, about)
    entered(folder, mould=place.mould, unit=place.unit, shown=train.stored is not None)
    if seat.why != "SIGHUP":
        print(f"{outcome[:1].upper()}{outcome[1:]}.")
        if taught is not None:
            print(STORED_LINE.format(**metrics))
        if trouble:
            print(f"stored, but it can be replayed with --open-loop only: {trouble}")
        print(f"report: {relative(folder / 'report.html')}")
    if train.interrupted:
        return INTERRUPTED
    return STOPPED if train.rig.supervisor.tripped or train.failure else DONE


def _figures(taught: Taught) -> dict[str, Scalar]:
    """What was taught, in numbers."""
    force = np.concatenate([piece.force for piece in taught.contacts])
    return {
        "contacts": len(taught.contacts),
        "path_length_m": sum(piece.ds * (len(piece.p) - 1) for piece in taught.contacts),
        "force_least_N": float(force.min()),
        "force_most_N": float(force.max()),
        "force_mean_N": float(force.mean()),
    }


def _shower(options: argparse.Namespace, cell: Cell, rig: Rig, robot: SimRobot, live: Alone) -> Shower:
    """Whoever the options name."""
    if options.device == HAND:
        hand = Hand.on(cell.grid, cell.placement, tool_down(rig.model), cell.tool.tip_radius)
        return Shower(source=hand, mode=lambda: HAND, ended=lambda: hand.done, name="a simulated hand")
    clock = time.monotonic if options.device in (JOG, *WORDS) else lambda: robot.time
    device = live.jog() if options.device == JOG else open_device(options.device, clock)
    moved = operator(
        read=Shaped(device=device).read, panel=Panel(modes=MODES[options.modes]), supervisor=rig.supervisor, pace=Pace()
    )
    return Shower(
        source=moved,
        mode=lambda: moved.panel.modes.mode.name,
        ended=lambda: not moved.reading.connected,
        name=device.name,
        device=device,
    )


def _read_too(device: Device | None, typed: Callable[[], list[str]] | None) -> Callable[[], list[str]] | None:
    """The keys that were typed, also while nobody asks the keyboard where the tool is to go: at home, for instance."""
    if typed is None or not isinstance(device, Keyboard):
        return typed

    def others() -> list[str]:
        device.read()
        return typed()

    return others


def _by_itself(session: Session, shower: Shower) -> Key | None:
    """The key that a session without anybody goes on with."""
    for key in (Key.GO_ON, Key.RECORD):
        if key in session.waits_for:
            return key
    return Key.STORE if Key.STORE in session.waits_for and shower.ended() else None


def _pace(options: argparse.Namespace) -> float:
    """Real time where a person or a device keeps it."""
    if options.pace is not None:
        return float(options.pace)
    return 0.0 if options.yes and options.device not in (JOG, *WORDS) else 1.0
