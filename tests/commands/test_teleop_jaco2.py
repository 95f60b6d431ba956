"""``burnish teleop --robot jaco2`` on the stand-in of the real arm: it moves for who said so, and no one else."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from commands.terminal import Terminal
from commands.test_teleop import HEAD, UP, Broken, row, samples
from hardware.conftest import clock, compiler, libraries, process, standin  # noqa: F401
from hardware.standin import SERIAL, StandIn, SteppedClock

from burnish.cli import main
from burnish.commands import real_arm
from burnish.commands.station import LAWS
from burnish.hardware.jaco2 import Jaco2

END = SERIAL[-4:]


class Asleep:
    """A watchdog for an arm on simulated time, whose cycles may take as long as they like."""

    def __init__(self, serial: str, library: str | None) -> None:
        self.serial = serial

    def __enter__(self) -> Asleep:
        return self

    def beat(self, in_torque_mode: bool) -> None: ...

    def __exit__(self, *exception: object) -> None: ...


class Typed(io.StringIO):
    """A terminal at which this was typed."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def words(tmp_path: Path) -> list[str]:
    """Up for 0.4 s, and at rest."""
    script = tmp_path / "script.txt"
    rows = ["0,0,0,0,0,0,0,00", "0.3,0,0,1,0,0,0,00", "0.7,0,0,0,0,0,0,00", "1.2,0,0,0,0,0,0,00"]
    script.write_text("\n".join([HEAD, *rows]) + "\n")
    return ["teleop", "--robot", "jaco2", "--device", str(script), "--out", str(tmp_path / "out")]


@pytest.fixture
def says(
    standin: StandIn,  # noqa: F811
    clock: SteppedClock,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> Callable[[str], None]:
    """What the person at the terminal answers; the arm, the device and the driver live by one simulated time."""
    monkeypatch.setattr(real_arm, "Jaco2", partial(Jaco2, clock=clock))
    monkeypatch.setattr(real_arm, "Watchdog", Asleep)
    monkeypatch.setattr("burnish.commands.station._clock_of", lambda robot: clock.now)
    monkeypatch.setattr("burnish.commands.teleop.typed_keys", lambda device: nullcontext())
    return lambda text: monkeypatch.setattr("sys.stdin", Typed(text))


def never_armed(standin: StandIn) -> bool:  # noqa: F811
    return standin.calls("SendAngularTorqueCommand") == 0 and standin.memory.mode == 0


def test_an_arm_that_is_confirmed_follows_the_operator_and_is_left_in_position_mode(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    says(f"{END}\n")
    assert main(words) == 0
    said = capsys.readouterr().out
    assert SERIAL in said
    assert "emergency stop" in said
    taught = samples(tmp_path / "out")
    # 0.4 s at 0.126 m/s and less, less the ramps.
    assert 0.01 < taught.p[-1][2] - taught.p[0][2] < 0.06
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)
    _, _, mode = standin.trace()
    assert mode.max() == 1.0
    assert mode[-1] == 0.0
    assert json.loads((tmp_path / "out" / "metrics.json").read_text())["supervisor_events"] == 0


@pytest.mark.parametrize("answer", ["", "\n", "y\n", "yes\n", f"{SERIAL[:4]}\n", f"{END}1\n"])
def test_without_the_arms_own_signs_it_is_never_armed(
    answer: str,
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    says(answer)
    assert main(words) == 2
    assert "not confirmed" in capsys.readouterr().err
    assert never_armed(standin)
    assert not (tmp_path / "out").exists()


def test_where_there_is_no_terminal_nobody_can_confirm(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(f"{END}\n"))
    assert main(words) == 2
    assert "at a terminal" in capsys.readouterr().err
    assert never_armed(standin)


def test_without_an_arm_it_is_refused_with_what_the_doctor_finds_first(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    capsys: pytest.CaptureFixture[str],
) -> None:
    says(f"{END}\n")
    assert main([*words, "--lib", "/nowhere.so"]) == 2
    refused = capsys.readouterr().err
    assert refused.count("\n") == 1
    assert main(["doctor", "--lib", "/nowhere.so"]) == 0
    said = capsys.readouterr().out.splitlines()
    first = next(k for k, line in enumerate(said) if line.startswith("missing"))
    assert said[first].removeprefix("missing").strip() in refused
    assert said[first + 1].strip().removeprefix("→ ") in refused


def test_several_arms_are_told_apart_by_their_serial_numbers(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    capsys: pytest.CaptureFixture[str],
) -> None:
    standin.memory.devices = 2
    says(f"{END}\n")
    assert main(words) == 2
    assert "name one of them with --serial" in capsys.readouterr().err
    assert main([*words, "--serial", "PJ0"]) == 2
    assert f"connected: {SERIAL}" in capsys.readouterr().err
    assert never_armed(standin)
    says(f"{END}\n")
    assert main([*words, "--serial", SERIAL]) == 0


def test_what_means_nothing_to_a_real_arm_is_refused(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for option in (["--arm", "ideal"], ["--mould", "dome"], ["--rate", "100"], ["--seed", "1"], ["--view"]):
        assert main([*words, *option]) == 2
        assert f"{option[0]} means nothing to --robot jaco2" in capsys.readouterr().err
    assert main(["teleop", "--device", words[4], "--serial", SERIAL]) == 2
    assert "--serial means nothing to --robot simulated" in capsys.readouterr().err


def test_an_arm_that_refuses_torque_mode_is_left_alone(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    capsys: pytest.CaptureFixture[str],
) -> None:
    standin.memory.refuse_torque_mode = 1
    says(f"{END}\n")
    assert main(words) == 2
    assert "torque mode refused" in capsys.readouterr().err
    assert standin.memory.mode == 0


def test_a_real_arm_that_was_stopped_is_left_to_its_position_mode_and_the_session_ends(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(LAWS, "OperationalSpace", lambda arm: Broken())
    monkeypatch.setattr("burnish.commands.teleop.typed_keys", lambda device: nullcontext(list))
    says(f"{END}\n")
    assert main(words) == 3
    assert standin.memory.mode == 0
    taught = samples(tmp_path / "out")
    assert np.abs(taught.dq[-1]).max() < np.deg2rad(1.0)
    assert "not finite" in json.loads((tmp_path / "out" / "metrics.json").read_text())["outcome"]


def test_a_cable_that_is_pulled_out_keeps_the_recording_and_says_so(
    words: list[str],
    says: Callable[[str], None],
    standin: StandIn,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun = real_arm.RealArm.write

    def write(self: real_arm.RealArm, command: object) -> object:
        if standin.calls("SendAngularTorqueCommand") > 170:
            standin.fail("GetAngularForce", 1015)
        return begun(self, command)  # type: ignore[arg-type]

    monkeypatch.setattr(real_arm.RealArm, "write", write)
    says(f"{END}\n")
    assert main(words) == 3
    told = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert told["outcome"].startswith("stopped: ")
    assert "in 3 cycles in a row" in told["outcome"]
    assert len(samples(tmp_path / "out").t) == told["cycles"]
    assert standin.memory.mode == 0


@pytest.mark.slow
def test_a_person_arms_the_arm_moves_it_by_keys_and_leaves_it(
    standin: StandIn,  # noqa: F811
    tmp_path: Path,
) -> None:
    standin.reset(realtime=True)
    words = ("teleop", "--robot", "jaco2", "--device", "keyboard", "--out", str(tmp_path / "out"))
    with Terminal(*words) as terminal:
        terminal.until("anything else leaves it alone:")
        assert standin.memory.mode == 0
        terminal.type(f"{END}\r")
        start = row(terminal.until(lambda text: "keys        q quit" in text), "position")[2]
        assert standin.memory.mode == 1
        terminal.until(lambda text: row(text, "position")[2] > start + 0.01, typing=UP)
        terminal.type("q")
        assert terminal.ends() == 0
    assert standin.memory.mode == 0
    assert samples(tmp_path / "out").p[-1][2] > start
