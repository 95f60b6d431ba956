"""The vendor's library: found, recognised, called with the right numbers, and every refusal of it made an error."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hardware.memory import FUNCTIONS
from hardware.standin import SERIAL, StandIn
from numpy.testing import assert_allclose

from burnish.errors import HardwareError, InputError
from burnish.hardware.kinova import Kinova
from burnish.hardware.kinova_codes import CODES, ConnectionLostError, NackError, UnknownCodeError, VendorError
from burnish.hardware.kinova_library import REFUSAL_IS_NO_ERROR, VARIABLE, Library, LibraryMissingError, find
from burnish.hardware.kinova_types import ControlMode, Inactivity
from burnish.hardware.network import Network
from burnish.sim.robot import HOME

VENDORS_CODES = [
    *range(1001, 1023),
    *range(2001, 2016),
    *range(2100, 2103),
    *range(5001, 5004),
    9999,
    666,
]
"""All error codes of the vendor's headers."""

ZEROS = np.zeros(6)
CALLS: dict[str, Callable[[Kinova], Any]] = {
    "GetDevices": Kinova.devices,
    "SetActiveDevice": lambda kinova: kinova.choose(SERIAL),
    "StartControlAPI": Kinova.start,
    "SetAngularControl": Kinova.start,
    "GetAPIVersion": Kinova.versions,
    "GetCodeVersion": Kinova.versions,
    "GetAngularPosition": Kinova.positions,
    "GetAngularForce": Kinova.torques,
    "GetAngularCommand": lambda kinova: kinova.send_fingers(np.zeros(3)),
    "GetAngularTorqueGravityEstimation": Kinova.gravity_estimate,
    "GetTrajectoryTorqueMode": Kinova.mode,
    "GetGlobalTrajectoryInfo": Kinova.queued,
    "SwitchTrajectoryTorque": lambda kinova: kinova.switch(ControlMode.POSITION),
    "SendAngularTorqueCommand": lambda kinova: kinova.send_torque(ZEROS),
    "SendBasicTrajectory": lambda kinova: kinova.send_velocity(ZEROS),
    "EraseAllTrajectories": Kinova.erase,
    "MoveHome": Kinova.home,
    "InitFingers": Kinova.open_fingers,
    "SetTorqueControlType": Kinova.set_direct_torque,
    "SetTorqueActuatorGain": lambda kinova: kinova.set_actuators(0.0, 0.0),
    "SetTorqueActuatorDamping": lambda kinova: kinova.set_actuators(0.0, 0.0),
    "SetTorqueSafetyFactor": lambda kinova: kinova.set_safety_factor(1.0),
    "SetTorqueVibrationController": lambda kinova: kinova.set_vibration_controller(1.0),
    "SetTorqueInactivityType": lambda kinova: kinova.set_inactivity(Inactivity.HOLD_POSITION),
    "SetAngularTorqueMinMax": lambda kinova: kinova.set_torque_limits(np.ones(6)),
    "SetGravityPayload": lambda kinova: kinova.set_gravity(np.zeros(16), 0.0, np.zeros(3)),
    "SetGravityOptimalZParam": lambda kinova: kinova.set_gravity(np.zeros(16), 0.0, np.zeros(3)),
    "SetGravityType": lambda kinova: kinova.set_gravity(np.zeros(16), 0.0, np.zeros(3)),
    "SetTorqueZero": lambda kinova: kinova.zero_torque(0),
    "SetJointZero": lambda kinova: kinova.zero_position(0),
    "CloseAPI": Kinova.close,
}


# Found and recognised.


def test_the_library_is_taken_from_the_option_before_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, other = tmp_path / "given.so", tmp_path / "other.so"
    given.touch()
    other.touch()
    monkeypatch.setenv(VARIABLE, str(other))
    assert find(given) == given
    assert find() == other


def test_a_missing_library_is_refused_with_the_way_to_get_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr("burnish.hardware.kinova_library.FOLDERS", (str(tmp_path),))
    with pytest.raises(LibraryMissingError, match=rf"install Kinova's JACO2 SDK.*kinova-ros.*{VARIABLE}"):
        find()
    with pytest.raises(LibraryMissingError, match=r"no file .*nowhere\.so"):
        find(tmp_path / "nowhere.so")


def test_the_vendors_usual_place_is_looked_into(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr("burnish.hardware.kinova_library.FOLDERS", ("/nowhere", str(tmp_path)))
    (tmp_path / "EthCommandLayerUbuntu.so").touch()
    assert find().name == "EthCommandLayerUbuntu.so"
    (tmp_path / "Kinova.API.USBCommandLayerUbuntu.so").touch()
    assert find().name == "Kinova.API.USBCommandLayerUbuntu.so"


def test_a_file_that_is_no_library_or_another_one_is_refused(tmp_path: Path) -> None:
    text = tmp_path / "text.so"
    text.write_text("no library")
    with pytest.raises(LibraryMissingError, match=r"cannot be loaded .*; install"):
        Library(text)
    with pytest.raises(LibraryMissingError, match="exports no GetDevices"):
        Library("libm.so.6")


@pytest.mark.parametrize("actuators", [7, 6])
@pytest.mark.parametrize("ethernet", [False, True])
def test_layer_and_layout_are_told_by_the_symbols_and_work(
    standin: StandIn, libraries: dict[tuple[int, bool], Path], actuators: int, ethernet: bool
) -> None:
    library = Library(libraries[actuators, ethernet])
    assert (library.layout.actuators, library.ethernet) == (actuators, ethernet)
    with Kinova(library, Network() if ethernet else None) as kinova:
        device = kinova.devices()[0]
        assert (device.serial, device.model, device.firmware) == (SERIAL, "JACO2 6DOF service", (6, 2, 5))
        kinova.choose(SERIAL)
        assert standin.memory.active.decode() == SERIAL
        assert_allclose(kinova.positions(), HOME, atol=1e-3)
        # A struct by value, with fields before and behind the actuators.
        kinova.send_fingers([0.1, 0.2, 0.3])
        kinova.send_velocity([0.1, -0.2, 0.3, -0.4, 0.5, -0.6])
        _, point = (standin.memory.ring[i].value for i in range(2))
        assert_allclose(point[:8], [8, 0, *np.rad2deg([0.1, -0.2, 0.3, -0.4, 0.5, -0.6])], rtol=1e-6)
        fingers = standin.memory.ring[0].value
        assert fingers[1] == 1
        # 6800 units are 80°.
        assert_allclose(fingers[8:11], np.rad2deg([0.1, 0.2, 0.3]) * 6800.0 / 80.0, rtol=1e-6)


def test_a_symbol_that_the_library_lacks_is_named(libraries: dict[tuple[int, bool], Path]) -> None:
    with pytest.raises(LibraryMissingError, match="does not export InitEthernetAPI"):
        Library(libraries[7, False]).call("InitEthernetAPI", None)


# Called.


def test_positions_are_in_radians_and_fingers_too(standin: StandIn, kinova: Kinova) -> None:
    standin.memory.position[:] = [90.0, 180.0, -90.0, 720.0, 45.0, 0.5]
    standin.memory.fingers[:] = [0.0, 3400.0, 6800.0]
    assert_allclose(kinova.positions(), [np.pi / 2, np.pi, -np.pi / 2, 4 * np.pi, np.pi / 4, np.deg2rad(0.5)])
    assert_allclose(kinova.fingers(), np.deg2rad([0.0, 40.0, 80.0]))


def test_torques_are_newton_metres_in_both_directions(standin: StandIn, kinova: Kinova) -> None:
    standin.memory.torque[:] = [1.5, -2.5, 3.5, -0.5, 0.25, 0.125]
    assert_allclose(kinova.torques(), [1.5, -2.5, 3.5, -0.5, 0.25, 0.125])
    kinova.send_torque(np.array([1.0, 2.0, 3.0, -4.0, 5.0, 6.0]))
    assert list(standin.memory.torque_command) == [1.0, 2.0, 3.0, -4.0, 5.0, 6.0]


def test_buffers_are_as_long_as_the_vendor_reads_them(kinova: Kinova, monkeypatch: pytest.MonkeyPatch) -> None:
    lengths: dict[str, int] = {}

    def note(name: str, *words: Any) -> None:
        lengths[name] = getattr(words[0], "_length_", 0)

    with monkeypatch.context() as patch:
        patch.setattr(kinova, "_call", note)
        kinova.send_torque(ZEROS)
        kinova.gravity_estimate()
        kinova.set_actuators(0.0, 0.0)
        kinova.set_gravity(np.zeros(16), 0.0, np.zeros(3))
    assert lengths == {
        "SendAngularTorqueCommand": 70,
        "GetAngularTorqueGravityEstimation": 70,
        "SetTorqueActuatorGain": 70,
        "SetTorqueActuatorDamping": 70,
        "SetGravityOptimalZParam": 42,
        "SetGravityPayload": 4,
        "SetGravityType": 0,
    }


def test_what_was_read_does_not_change_with_the_next_reading(standin: StandIn, kinova: Kinova) -> None:
    first = kinova.positions()
    standin.memory.position[:] = [0.0] * 6
    kinova.positions()
    assert_allclose(first, HOME, atol=1e-3)


# Refused.


def test_every_code_of_the_vendor_is_known() -> None:
    assert sorted(CODES) == sorted(VENDORS_CODES)


def test_every_call_of_the_stand_in_is_tried_below() -> None:
    # Starting is tried on its own; the velocity of the firmware is not used, because it is not trusted.
    assert set(CALLS) | {"InitAPI", "InitEthernetAPI", "StopControlAPI", "GetAngularVelocity"} == set(FUNCTIONS)


@pytest.mark.parametrize("call", CALLS)
def test_every_code_of_every_call_is_an_error_with_a_remedy(standin: StandIn, kinova: Kinova, call: str) -> None:
    for code in VENDORS_CODES:
        standin.fail(call, code)
        if code == 2005 and call in REFUSAL_IS_NO_ERROR:
            CALLS[call](kinova)
            continue
        with pytest.raises(VendorError) as caught:
            CALLS[call](kinova)
        kind, meaning, remedy = CODES[code]
        assert (type(caught.value), caught.value.code, caught.value.call) == (kind, code, call)
        assert str(caught.value) == f"{call}: {meaning} (code {code}); {remedy}"
        assert isinstance(caught.value, HardwareError)


@pytest.mark.parametrize("code", VENDORS_CODES)
def test_every_code_at_the_start_is_an_error(
    standin: StandIn, libraries: dict[tuple[int, bool], Path], code: int
) -> None:
    for ethernet, call in ((False, "InitAPI"), (True, "InitEthernetAPI")):
        standin.fail(call, code)
        with pytest.raises(CODES[code][0], match=rf"{call}: .*\(code {code}\)"):
            Kinova(Library(libraries[7, ethernet]))


def test_zero_is_no_success_and_an_unheard_code_is_an_error(standin: StandIn, kinova: Kinova) -> None:
    for code in (0, -1, 2, 4711):
        standin.fail("EraseAllTrajectories", code)
        with pytest.raises(UnknownCodeError, match=rf"code {code}\)"):
            kinova.erase()


def test_kinds_of_errors_that_a_program_may_want_to_tell_apart() -> None:
    assert {code for code, (kind, *_) in CODES.items() if kind is NackError} == {2003, 2005, 9999}
    assert {1007, 1011, 1015, 1022, 2004} <= {c for c, (kind, *_) in CODES.items() if kind is ConnectionLostError}


def test_a_library_without_an_arm_behind_it_says_so(
    libraries: dict[tuple[int, bool], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # In a process of its own: here the library has its memory already.
    script = "import sys; from burnish.hardware.kinova import *; from burnish.hardware.kinova_library import *\n"
    script += "try: Kinova(Library(sys.argv[1]))\nexcept Exception as error: print(type(error).__name__, error)"
    words = [sys.executable, "-c", script, str(libraries[7, False])]
    environment = os.environ | {"BURNISH_STANDIN": str(tmp_path / "none")}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("NotStartedError InitAPI: ")


def test_addresses_reach_the_library_in_network_order() -> None:
    configuration = Network(robot="1.2.3.4", timeout=0.25).configuration()
    assert configuration.robotIpAddress.to_bytes(8, "little") == bytes([1, 2, 3, 4, 0, 0, 0, 0])
    assert (configuration.robotPort, configuration.rxTimeOutInMs) == (55000, 250)


@pytest.mark.parametrize("wrong", [{"robot": "the arm"}, {"timeout": 0.0}, {"timeout": float("nan")}])
def test_addresses_that_are_none_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(InputError, match="Network: "):
        Network(**wrong)  # type: ignore[arg-type]


def test_a_reading_waits_for_an_arm_whose_process_does_not_get_the_processor(standin: StandIn, kinova: Kinova) -> None:
    # A real arm lives on while the computer is busy; here its readings would all be alike.
    standin.reset(realtime=True)
    time.sleep(0.05)
    standin.pause()
    timer = threading.Timer(0.06, standin.go_on)
    timer.start()
    time.sleep(0.02)
    before, asked = standin.memory.time, time.monotonic()
    kinova.positions()
    assert time.monotonic() - asked > 0.02
    assert standin.memory.time > before
    timer.join()
