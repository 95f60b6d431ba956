"""The real arm under ``burnish teleop``: found, confirmed by whoever stands beside it, and watched while it moves."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import cast

from typing_extensions import Self

from burnish.commands import doctor
from burnish.commands.devices import connected
from burnish.core import Array, Command, State
from burnish.errors import HardwareError, InputError
from burnish.hardware.jaco2 import Jaco2
from burnish.hardware.kinova import Device
from burnish.hardware.link import PERIOD
from burnish.hardware.torque_mode import TorqueSetup
from burnish.hardware.watchdog import Watchdog
from burnish.model.model import Model
from burnish.runtime.session import ArmWithModes, Session
from burnish.runtime.supervisor import Supervisor

SIGNS = 4
"""Last signs of the serial number that are typed: whoever does has read which arm it is."""
ABOUT_TO_MOVE = """\
This moves a real arm: {model}, serial {serial}, firmware {firmware}.
It goes into torque mode where it stands, and from then on it does what the operator says. Nobody may touch it for two
seconds. Keep everybody out of its reach and the emergency stop at hand.
Type the last {signs} signs of its serial number to arm it; anything else leaves it alone: """


class RealArm:
    """A JACO2 in torque mode, with its own watchdog; a `Robot`. Left, it holds by its position mode."""

    period = PERIOD
    """Time between two samples [s]."""

    def __init__(self, device: Device, model: Model, supervisor: Supervisor, library: str | None) -> None:
        """The arm that was found and confirmed; the supervisor begins with ``start=Mode.IDLE``."""
        self._jaco2 = Jaco2(model, serial=device.serial, library=library)
        self._watchdog = Watchdog(device.serial, library=library)
        # The driver's `__exit__` asks for the type of an exception, which `Session` gives.
        arm_with_modes = cast(ArmWithModes, self._jaco2)
        self._session = Session(arm_with_modes, TorqueSetup.thesis_a(), supervisor, self._watchdog.beat)
        self._stack = ExitStack()

    @property
    def late_cycles(self) -> int:
        """Cycles that began after their time."""
        return self._jaco2.late_cycles

    def __enter__(self) -> Self:
        """Connect and arm, with all checks.

        Raises:
            HardwareError: if something stands against it; the arm is then in position mode.
        """
        with ExitStack() as stack:
            stack.enter_context(self._watchdog)
            stack.enter_context(self._session)
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def read(self) -> State:
        """The next measurement."""
        return self._session.read()

    def write(self, command: Command) -> Array:
        """Send a torque."""
        return self._session.write(command)


def found(serial: str | None, library: str | None) -> Device:
    """The arm with this serial number, or the only one there is; nothing is moved.

    Raises:
        HardwareError: if there is none; with what ``burnish doctor`` finds first.
        InputError: if there are several and none was named.
    """
    for finding in doctor.arm(library):
        if finding.verdict == doctor.BAD:
            raise HardwareError(f"{finding.what}; {finding.remedy}")
    arms = {arm.serial: arm for arm in connected(library)}
    there = ", ".join(arms)
    if serial is None and len(arms) > 1:
        raise InputError(f"{len(arms)} arms are connected: {there}; name one of them with --serial")
    if serial is not None and serial not in arms:
        raise HardwareError(f"no arm has the serial number {serial}; connected: {there}; give that of one of them")
    return arms[serial] if serial is not None else next(iter(arms.values()))


def confirmed(arm: Device) -> None:
    """Ask whoever sits at the terminal whether this arm may move.

    Raises:
        InputError: if nobody can answer, or the answer is anything but the arm's own signs.
    """
    if sys.stdin is None or not sys.stdin.isatty():
        raise InputError("a real arm is armed by somebody at a terminal, and there is none here; run it in one")
    firmware = ".".join(map(str, arm.firmware))
    try:
        answer = input(ABOUT_TO_MOVE.format(model=arm.model, serial=arm.serial, firmware=firmware, signs=SIGNS))
    except EOFError:
        answer = ""
    if answer.strip() != arm.serial[-SIGNS:]:
        raise InputError(f"not confirmed: {arm.serial[-SIGNS:]!r} was expected; the arm was left alone")
