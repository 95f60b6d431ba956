"""`burnish doctor` and `burnish devices`: what they find, what they miss, and the next step they name."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from hardware.standin import SERIAL, StandIn

from burnish.cli import main
from burnish.commands import devices, doctor
from burnish.hardware.inventory import Plugged, arms_on_usb, space_mice, spacenavd_runs
from burnish.hardware.kinova_library import VARIABLE


def usb(root: Path, name: str, **files: str) -> None:
    folder = root / name
    folder.mkdir(parents=True)
    for file, content in files.items():
        (folder / file).write_text(content + "\n")


@pytest.fixture
def nothing_plugged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A machine without an arm, without its library and without operator devices."""
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr("burnish.hardware.kinova_library.FOLDERS", (str(tmp_path / "lib"),))
    for module in (devices, doctor):
        monkeypatch.setattr(module, "arms_on_usb", list)
        monkeypatch.setattr(module, "space_mice", list)
    monkeypatch.setattr(doctor, "spacenavd_runs", lambda: False)
    monkeypatch.setenv("SPNAV_SOCKET", str(tmp_path / "none.sock"))


def arm(usable: bool) -> Plugged:
    return Plugged(name="Kinova inc. JACO", serial="K1", node=Path("/dev/bus/usb/001/007"), usable=usable)


def mouse(usable: bool) -> Plugged:
    return Plugged(
        name="3Dconnexion SpaceMouse",
        serial="",
        node=Path("/dev/hidraw3"),
        usable=usable,
        vendor=0x256F,
        product=0xC635,
    )


# The system's lists.


def test_an_arm_is_found_on_the_usb_by_its_vendor(tmp_path: Path) -> None:
    usb(tmp_path / "sys", "1-2", idVendor="22CD", busnum="1", devnum="7", manufacturer="Kinova inc.", serial="PJ1")
    usb(tmp_path / "sys", "1-3", idVendor="1d6b", busnum="1", devnum="8")
    (tmp_path / "sys" / "1-2:1.0").mkdir()
    node = tmp_path / "dev" / "001" / "007"
    found = arms_on_usb(tmp_path / "sys", tmp_path / "dev")
    assert found == [Plugged(name="Kinova inc.", serial="PJ1", node=node, usable=False)]
    node.parent.mkdir(parents=True)
    node.touch()
    assert arms_on_usb(tmp_path / "sys", tmp_path / "dev")[0].usable


def test_space_mice_are_told_from_other_devices(tmp_path: Path) -> None:
    for number, ids in enumerate(("0000256F:0000C635", "0000046D:0000C626", "0000046D:0000C52B", "00001234:00005678")):
        folder = tmp_path / "sys" / f"hidraw{number}" / "device"
        folder.mkdir(parents=True)
        (folder / "uevent").write_text(f"DRIVER=hid\nHID_ID=0003:{ids}\nHID_NAME=device {number}\nHID_UNIQ=\n")
    found = space_mice(tmp_path / "sys", tmp_path / "dev")
    assert [(device.name, device.node.name) for device in found] == [("device 0", "hidraw0"), ("device 1", "hidraw1")]
    assert [(device.vendor, device.product) for device in found] == [(0x256F, 0xC635), (0x046D, 0xC626)]


def test_a_machine_without_such_lists_has_nothing(tmp_path: Path) -> None:
    assert arms_on_usb(tmp_path / "none") == []
    assert space_mice(tmp_path / "none") == []


def test_spacenavd_is_found_by_its_socket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # the path of a socket may be 107 bytes long
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("spnav.sock")
        assert spacenavd_runs(Path("spnav.sock"))
    Path("file").touch()
    assert not spacenavd_runs(Path("file"))
    assert not spacenavd_runs(tmp_path / "none")


# The verbs.


@pytest.mark.usefixtures("nothing_plugged")
def test_without_anything_doctor_names_the_library_as_the_next_step(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "missing  Kinova's library is not in " in out
    assert "note     no Kinova arm on the USB" in out
    assert "note     no SpaceMouse and no spacenavd" in out
    assert out.splitlines()[-1].startswith("next: install Kinova's JACO2 SDK")
    assert main(["devices"]) == 0
    assert capsys.readouterr().out == "nothing is connected; 'burnish doctor' says what to look at\n"


@pytest.mark.usefixtures("nothing_plugged")
def test_a_device_without_permission_gets_its_udev_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, "arms_on_usb", lambda: [arm(usable=False)])
    monkeypatch.setattr(doctor, "space_mice", lambda: [mouse(usable=False)])
    main(["doctor"])
    out = capsys.readouterr().out
    assert "Kinova inc. JACO at /dev/bus/usb/001/007: no permission" in out
    assert 'ATTR{idVendor}=="22cd", MODE="0666"' in out.splitlines()[-1]
    assert "3Dconnexion SpaceMouse at /dev/hidraw3: no permission" in out
    assert 'KERNEL=="hidraw*", ATTRS{idVendor}=="256f"' in out


@pytest.mark.usefixtures("nothing_plugged")
def test_devices_without_the_library_shows_what_the_usb_shows(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(devices, "arms_on_usb", lambda: [arm(usable=False)])
    monkeypatch.setattr(devices, "space_mice", lambda: [mouse(usable=True)])
    main(["devices"])
    assert capsys.readouterr().out.splitlines() == [
        "arm        Kinova inc. JACO, serial K1 at /dev/bus/usb/001/007 (no permission); Kinova's library is missing",
        "operator   3Dconnexion SpaceMouse at /dev/hidraw3",
    ]


def test_with_the_library_both_name_the_arm(standin: StandIn, capsys: pytest.CaptureFixture[str]) -> None:
    standin.memory.devices = 2
    main(["devices"])
    out = capsys.readouterr().out
    assert f"arm        JACO2 6DOF service, serial {SERIAL}, firmware 6.2.5" in out
    assert "serial PJ00650019161750002" in out
    main(["doctor"])
    out = capsys.readouterr().out
    assert "USB layer, layout for 7 actuators" in out
    assert f"ok       arm JACO2 6DOF service, serial {SERIAL}, firmware 6.2.5" in out
    assert "interface 5.2.0" in out


def test_doctor_passes_on_what_the_library_says(standin: StandIn, capsys: pytest.CaptureFixture[str]) -> None:
    standin.memory.devices = 0
    main(["doctor"])
    assert "next: check the cable and the arm's power switch" in capsys.readouterr().out
    standin.fail("GetDevices", 1015)
    main(["doctor"])
    assert "no arm was found (code 1015)" in capsys.readouterr().out
    main(["devices"])
    assert "arm        none through the library: GetDevices: no arm was found (code 1015)" in capsys.readouterr().out


def test_a_library_that_is_named_and_is_not_there_is_said(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    main(["doctor", "--lib", str(tmp_path / "none.so")])
    assert "missing  there is no file" in capsys.readouterr().out


def test_doctor_loads_no_engine() -> None:
    code = "import sys; from burnish.cli import main; main(['devices']); main(['doctor'])\n"
    code += "assert not {'mujoco', 'pinocchio'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=os.environ | {VARIABLE: "none"})
