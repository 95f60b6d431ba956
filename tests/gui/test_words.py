from math import nan

import pytest

from burnish.gui import words
from burnish.runtime.machine import Mode


@pytest.mark.parametrize("mode", list(Mode))
def test_every_state_of_the_supervisor_has_words(mode: Mode) -> None:
    assert words.MODES[mode][0]


def test_a_phase_with_more_to_it_is_found_by_its_beginning() -> None:
    assert words.phase("record contact twist") == words.PHASES["record contact"]


def test_an_unknown_phase_says_its_own_name() -> None:
    assert words.phase("somersault") == "somersault"


def test_what_is_no_number_is_a_dash() -> None:
    assert words.number(nan, "N") == "– N"
    assert words.duration(float("inf")) == "–"


@pytest.mark.parametrize(
    ("seconds", "shown"), [(0.4, "0 s"), (59.4, "59 s"), (59.6, "1 min 00 s"), (196.0, "3 min 16 s")]
)
def test_times_are_in_minutes_and_seconds(seconds: float, shown: str) -> None:
    assert words.duration(seconds) == shown


def test_the_last_refusal_of_a_verb_is_found_among_its_words() -> None:
    assert (
        words.refusal("planning\nburnish: a note\nburnish: no such mould; give another\n\n")
        == "no such mould; give another"
    )
    assert words.refusal("done\n") == ""


def test_figures_have_units_and_leave_out_what_is_not_there() -> None:
    rows = dict(words.figures({"force_rms_N": 0.2831, "mould": "dome", "stored": True}))
    assert rows == {"force error, RMS": "0.28 N"}


def test_two_runs_stand_side_by_side_even_where_one_lacks_a_figure() -> None:
    rows = words.compared({"force_rms_N": 0.28, "touch_peak_N": 2.0}, {"force_rms_N": 0.31})
    assert rows == [("force error, RMS", "0.28 N", "0.31 N"), ("highest touch", "2.0 N", "–")]
