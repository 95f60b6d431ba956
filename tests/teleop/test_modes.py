"""Every transition of both machines against tables typed from the theses, and what no sequence of buttons may break."""

from __future__ import annotations

import random
from itertools import product

import pytest

from burnish.teleop import modes_a, modes_b
from burnish.teleop.modes import Frame, Mode, Modes, Panel, Wanted
from burnish.teleop.modes_a import ModesA
from burnish.teleop.modes_b import ModesB

PUSHED = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6)
NOWHERE = (0.0, 0.0, 0.0)

# Thesis A, figure 6.4 and the text below it: (mode, mode left for the fingers) × button → the same.
FIGURE_6_4 = {
    (("free", None), 1): ("fingers", "free"),
    (("free", None), 2): ("translation", None),
    (("translation", None), 1): ("fingers", "translation"),
    (("translation", None), 2): ("rotation", None),
    (("rotation", None), 1): ("fingers", "rotation"),
    (("rotation", None), 2): ("free", None),
    (("fingers", "free"), 1): ("free", None),
    (("fingers", "free"), 2): ("free", None),
    (("fingers", "translation"), 1): ("translation", None),
    (("fingers", "translation"), 2): ("translation", None),
    (("fingers", "rotation"), 1): ("rotation", None),
    (("fingers", "rotation"), 2): ("rotation", None),
}
MODES_A = {mode.name: mode for mode in (modes_a.FREE, modes_a.TRANSLATION, modes_a.ROTATION, modes_a.FINGERS)}

# Thesis B, section 3.3: flag_mode 0 … 4, on the left button; what moves, and in whose axes.
SECTION_3_3 = {
    "polishing": ("base", None, None),
    "turn about tool": ("base", "tool", None),
    "all in base": ("base", "base", None),
    "all in tool": ("tool", "tool", None),
    "fingers": (None, None, 3),
}


def machine_a(mode: str, left: str | None) -> ModesA:
    return ModesA(mode=MODES_A[mode], left=MODES_A[left or "free"])


def what_moves(mode: Mode) -> tuple[str | None, str | None, int | None]:
    def frame(of: Frame | None) -> str | None:
        return None if of is None else of.value

    return frame(mode.translation), frame(mode.rotation), mode.fingers


@pytest.mark.parametrize(("before", "after"), FIGURE_6_4.items(), ids=lambda item: str(item))
def test_every_transition_of_a_is_that_of_figure_6_4(
    before: tuple[tuple[str, str | None], int], after: tuple[str, str | None]
) -> None:
    machine = machine_a(*before[0]).pressed(before[1])
    assert machine.mode.name == after[0]
    if after[1] is not None:
        assert machine.left.name == after[1]


def test_the_table_of_a_names_every_state_and_button() -> None:
    moving, fingers = product(("free", "translation", "rotation"), (None,)), product(("fingers",), MODES_A)
    states = [*moving, *(state for state in fingers if state[1] != "fingers")]
    assert set(FIGURE_6_4) == set(product(states, (1, 2)))


@pytest.mark.parametrize("state", dict.fromkeys(state for state, _ in FIGURE_6_4))
@pytest.mark.parametrize("button", [0, 3, 4, 16])
def test_other_buttons_change_nothing_in_a(state: tuple[str, str | None], button: int) -> None:
    machine = machine_a(*state)
    assert machine.pressed(button) == machine


@pytest.mark.parametrize("mode", [modes_a.FREE, modes_a.TRANSLATION, modes_a.ROTATION])
def test_without_fingers_button_1_of_a_does_nothing_and_is_not_offered(mode: Mode) -> None:
    machine = ModesA(mode=mode, fitted=False)
    assert machine.pressed(1) == machine
    assert set(machine.keys) == {2}


def test_what_moves_in_a_is_what_chapter_6_says() -> None:
    assert {name: what_moves(mode) for name, mode in MODES_A.items()} == {
        "free": ("base", "tool", None),
        "translation": ("base", None, None),
        "rotation": (None, "tool", None),
        "fingers": (None, None, 5),
    }


@pytest.mark.parametrize("fitted", [True, False])
def test_the_left_button_goes_round_b_in_the_order_of_section_3_3(fitted: bool) -> None:
    order = [name for name in SECTION_3_3 if fitted or name != "fingers"]
    machine = ModesB(fitted=fitted)
    for name, after in zip(order, order[1:] + order[:1], strict=True):
        assert machine.mode.name == name
        assert machine.keys == {1: after}
        machine = machine.pressed(1)
    assert machine.mode.name == "polishing"


def test_what_moves_in_b_is_what_section_3_3_says() -> None:
    assert {mode.name: what_moves(mode) for mode in modes_b.ROUND} == SECTION_3_3


@pytest.mark.parametrize("mode", modes_b.ROUND, ids=lambda mode: mode.name)
@pytest.mark.parametrize("button", [0, 2, 3, 16])
def test_other_buttons_change_nothing_in_b(mode: Mode, button: int) -> None:
    assert ModesB(mode=mode).pressed(button) == ModesB(mode=mode)


@pytest.mark.parametrize("mode", [*MODES_A.values(), *modes_b.ROUND], ids=lambda mode: mode.name)
def test_a_mode_takes_its_own_axes_and_no_others(mode: Mode) -> None:
    machine = ModesA(mode=mode) if mode in MODES_A.values() else ModesB(mode=mode)
    wanted = Panel(modes=machine).wanted(PUSHED)
    assert wanted.push == (PUSHED[:3] if mode.translation else NOWHERE)
    assert wanted.turn == (PUSHED[3:] if mode.rotation else NOWHERE)
    assert wanted.close == (0.0 if mode.fingers is None else PUSHED[mode.fingers])


# What a panel makes of buttons: (down before, down now, held before) → held now; None is "never seen".
DEADMAN = {
    (None, False, False): False,
    (None, True, False): False,
    (False, False, False): False,
    (False, True, False): True,
    (True, True, False): False,
    (True, False, False): False,
    (True, True, True): True,
    (True, False, True): False,
    (False, True, True): True,
    (False, False, True): False,
}


@pytest.mark.parametrize(("state", "held"), DEADMAN.items(), ids=lambda item: str(item))
def test_the_deadman_counts_once_it_was_seen_released(state: tuple[bool | None, bool, bool], held: bool) -> None:
    before, now, was = state
    panel = Panel(modes=ModesB(), deadman=1, held=was, down=None if before is None else (before,))
    assert panel.step((now,)).held is held


def test_a_button_acts_when_it_goes_down_and_only_then() -> None:
    panel = Panel(modes=ModesB())
    names = []
    for down in (False, True, True, False, False, True):
        panel = panel.step((down, False))
        names.append(panel.modes.mode.name)
    assert names == ["polishing", *["turn about tool"] * 4, "all in base"]


def test_a_button_that_is_down_at_the_start_does_nothing_until_it_was_released() -> None:
    panel = Panel(modes=ModesA()).step((True, True)).step((True, True)).step((False, False))
    assert panel.modes.mode is modes_a.FREE
    assert panel.step((False, True)).modes.mode is modes_a.TRANSLATION


def test_a_device_that_grows_buttons_presses_none() -> None:
    panel = Panel(modes=ModesA()).step((False, False)).step((True, True, True))
    assert panel.modes.mode is modes_a.FREE


def test_after_the_arm_was_taken_the_deadman_is_pressed_anew() -> None:
    panel = Panel(modes=ModesB(), deadman=2).step((False, False)).step((False, True))
    assert panel.live
    panel = panel.let_go()
    assert not panel.step((False, True)).live
    assert panel.step((False, False)).step((False, True)).live


@pytest.mark.parametrize(
    ("modes", "deadman"), [(ModesA(), None), (ModesA(), 3), (ModesB(), None), (ModesB(), 2), (ModesB(fitted=False), 2)]
)
def test_no_sequence_of_events_breaks_what_has_to_hold(modes: Modes, deadman: int | None) -> None:
    rng = random.Random(7)
    # 500 walks of 200 events each: 10⁵ a machine, and its prefixes with them.
    for _ in range(500):
        panel, left, released = Panel(modes=modes, deadman=deadman), modes.mode, False
        buttons = tuple(rng.random() < 0.5 for _ in range(3))
        for _ in range(200):
            before = panel
            event = rng.randrange(4)
            if event == 3:
                panel = panel.let_go()
                released = deadman is not None and panel.down is not None and not panel.down[deadman - 1]
            else:
                buttons = tuple(down != (number == event) for number, down in enumerate(buttons))
                panel = panel.step(buttons)
                if deadman is not None:
                    released = released or not buttons[deadman - 1]
            wanted = panel.wanted(PUSHED)
            holding = deadman is None or (panel.down is not None and panel.down[deadman - 1] and released)
            if not holding:
                assert wanted == Wanted(), "moved without the deadman"
            mode, was = panel.modes.mode, before.modes.mode
            if mode.fingers is not None:
                assert wanted.push == wanted.turn == NOWHERE, "the arm moved with the fingers"
            elif wanted != Wanted():
                assert wanted.close == 0.0, "the fingers moved with the arm"
            if isinstance(panel.modes, ModesA):
                if mode.fingers is not None and was.fingers is None:
                    left = was
                elif mode.fingers is None and was.fingers is not None:
                    assert mode is left, "the fingers did not return where they came from"
            if event == 3 or (deadman is not None and event == deadman - 1):
                assert mode is was, "the deadman changed the mode"
