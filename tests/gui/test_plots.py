import numpy as np
import pytest
from gui_bench import glance

from burnish.gui.plots import CURVES, ROWS, SECONDS, WARNS, History, top


def test_an_empty_history_still_has_a_row_to_draw() -> None:
    for curve in range(len(CURVES)):
        assert all(len(line) == 1 for line in History().data(curve))


def test_each_curve_has_its_own_two_lines() -> None:
    history = History()
    history.add(
        glance(t=1.0, force=9.0, force_set=10.0, tilt=np.deg2rad(2.0), feed=0.015, feed_set=0.02), np.deg2rad(25.0)
    )
    lines = [[float(line[-1]) for line in history.data(curve)[1:]] for curve in range(4)]
    assert lines == [pytest.approx([9.0, 10.0]), pytest.approx([2.0, 0.0]), pytest.approx([15.0, 20.0]),
                     pytest.approx([25.0, WARNS])]  # fmt: skip


def test_the_latest_seconds_stay_and_the_older_ones_go() -> None:
    history = History()
    for t in np.arange(0.0, 100.0, 0.02):
        history.add(glance(t=float(t)), 0.5)
    t = history.data(0)[0]
    assert t[-1] == pytest.approx(99.98)
    assert 0.9 * SECONDS < t[-1] - t[0] <= SECONDS
    assert len(t) <= ROWS
    assert (np.diff(t) > 0.0).all()


def test_a_job_that_begins_anew_begins_an_empty_history() -> None:
    history = History()
    history.add(glance(t=50.0), 0.5)
    history.add(glance(t=0.1), 0.5)
    assert history.data(0)[0] == pytest.approx([0.1])


@pytest.mark.parametrize("value", [0.01, 1.99, 2.5, 17.0, 399.0])
def test_the_scale_ends_above_the_line_at_a_round_number(value: float) -> None:
    end = top(0, np.array([np.nan, value]))
    assert end >= max(value, CURVES[0].low)
    assert end <= max(2.0 * value, CURVES[0].low)


def test_nothing_to_draw_has_a_scale_too() -> None:
    assert top(0, np.array([np.nan])) == CURVES[0].low
