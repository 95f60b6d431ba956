from __future__ import annotations

import json

import numpy as np
import pytest

from burnish.analysis.metrics import (
    PassSeries,
    pass_metrics,
    tangential_speed,
    tilt,
    tilt_error,
    touch_peak,
    write_metrics,
)
from burnish.errors import InputError


def series(**changes):
    t = np.arange(0.0, 11.0, 0.001)
    values = {
        "t": t,
        "force": np.full_like(t, 10.0),
        "tilt": np.zeros_like(t),
        "speed": np.full_like(t, 0.02),
        "feed": 0.02,
        "force_set": 10.0,
        "feed_set": 0.02,
    }
    return PassSeries(**{**values, **{k: v(t) if callable(v) else v for k, v in changes.items()}})


def test_a_sine_error_has_the_rms_of_a_sine():
    result = pass_metrics(series(force=lambda t: 10.0 + 2.0 * np.sin(2 * np.pi * t)), [3.0])
    # Whole periods after the first second.
    assert result.force_rms_N == pytest.approx(np.sqrt(2.0), rel=1e-6)
    assert result.force_mean_N == pytest.approx(10.0, abs=1e-9)
    # |sin| stays below its 99th percentile for 99 % of a quarter period.
    assert result.force_p99_N == pytest.approx(2.0 * np.sin(0.99 * np.pi / 2), rel=1e-4)


def test_a_constant_error_is_its_own_rms_and_shifts_the_mean():
    result = pass_metrics(series(force=lambda t: np.full_like(t, 9.5)), [3.0])
    assert (result.force_rms_N, result.force_mean_N, result.force_p99_N) == pytest.approx((0.5, 9.5, 0.5))


def test_the_first_second_does_not_count():
    result = pass_metrics(series(force=lambda t: np.where(t < 0.9995, 25.0, 10.0)), [3.0])
    assert (result.force_rms_N, result.force_p99_N) == (0.0, 0.0)


def test_the_border_of_the_first_second_counts():
    late = series().scored()
    assert late.t[0] == pytest.approx(1.0, abs=1e-9)
    assert len(late.t) == 10_000


def test_contact_is_lost_below_a_fifth_of_a_newton():
    def force(t):
        return np.where((t >= 2.0) & (t < 2.5), 0.19, np.where((t >= 3.0) & (t < 4.0), 0.21, 10.0))

    # 0.5 s of 10 s.
    assert pass_metrics(series(force=force), [3.0]).contact_lost_pct == pytest.approx(5.0, abs=0.02)


def turned(axis, angle):
    """A turn about an axis, by Rodrigues' formula."""
    x, y, z = axis
    S = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * S + (1.0 - np.cos(angle)) * S @ S


def test_tilt_error_of_an_upright_tool_is_its_tilt():
    rng = np.random.default_rng(0)
    axis, normal, planned = (rows / np.linalg.norm(rows, axis=1, keepdims=True) for rows in rng.normal(size=(3, 50, 3)))
    assert tilt_error(axis, normal, -planned, planned) == pytest.approx(tilt(axis, normal), abs=1e-9)


def test_tilt_error_counts_from_the_lean_that_was_told_over_the_surface_that_is_there():
    normal, lean = np.array([[0.0, 0.0, 1.0]]), 0.2
    told = np.array([[np.sin(lean), 0.0, -np.cos(lean)]])
    assert tilt_error(told, normal, told, normal) == pytest.approx(0.0, abs=1e-12)
    assert tilt_error(-normal, normal, told, normal) == pytest.approx(lean)
    # Leaning as far to the other side is twice as wrong, not right.
    assert tilt_error(told * [-1.0, 1.0, 1.0], normal, told, normal) == pytest.approx(2.0 * lean)
    # A surface that is turned takes the wanted axis with it.
    Q = turned([0.0, 1.0, 0.0], 0.1)
    assert tilt_error(told @ Q.T, normal @ Q.T, told, normal) == pytest.approx(0.0, abs=1e-12)
    assert tilt_error(told, normal @ Q.T, told, normal) == pytest.approx(0.1)


def test_tilt_is_reported_in_degrees():
    result = pass_metrics(series(tilt=lambda t: np.radians(np.where(t < 6.0, 1.0, 3.0))), [3.0])
    assert result.tilt_rms_deg == pytest.approx(np.sqrt(5.0), rel=1e-4)
    assert result.tilt_max_deg == pytest.approx(3.0)


def test_feed_error_is_against_the_commanded_feed_and_relative_to_the_set_one():
    feed = np.full(11_000, 0.02)
    feed[6000:] = 0.01
    # 2 mm/s too fast everywhere, in the turns as well: 10 % of the recipe's 20 mm/s.
    result = pass_metrics(series(feed=feed, speed=feed + 0.002), [3.0])
    assert result.feed_rms_pct == pytest.approx(10.0)


def test_touch_peak_is_the_largest_force_of_its_own_series():
    assert pass_metrics(series(force=lambda t: np.full_like(t, 50.0)), [0.1, 2.75, 1.0]).touch_peak_N == 2.75


@pytest.mark.parametrize("force", [[], [1.0, np.nan]])
def test_a_touch_that_was_not_seen_is_refused(force):
    with pytest.raises(InputError):
        touch_peak(force)


@pytest.mark.parametrize("name", ["t", "force", "tilt", "speed", "feed"])
def test_a_series_with_a_nan_is_refused_by_name(name):
    values = np.full(11_000, 0.02) if name == "feed" else getattr(series(), name).copy()
    values[17] = np.nan
    with pytest.raises(InputError, match=f"{name} is not finite at sample 17"):
        series(**{name: values})


@pytest.mark.parametrize(
    "wrong",
    [
        {"force": np.zeros(3)},
        {"t": lambda t: t[::-1]},
        {"feed": 0.0},
        {"feed": lambda t: np.where(t < 5, 0.02, 0.0)},
    ],
)
def test_a_series_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(InputError):
        series(**wrong)


def test_a_pass_of_less_than_a_second_has_no_score():
    short = np.arange(0.0, 0.99, 0.01)
    ones = np.ones_like(short)
    with pytest.raises(InputError, match="settling"):
        pass_metrics(
            PassSeries(t=short, force=ones, tilt=ones, speed=ones, feed=ones, force_set=1.0, feed_set=1.0), [3.0]
        )


def test_the_names_are_those_of_the_file():
    assert list(pass_metrics(series(), [3.0]).as_dict()) == [
        "force_set_N",
        "force_rms_N",
        "force_mean_N",
        "force_p99_N",
        "touch_peak_N",
        "contact_lost_pct",
        "tilt_rms_deg",
        "tilt_max_deg",
        "feed_rms_pct",
    ]


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, np.pi / 2, np.pi - 1e-6])
def test_tilt_is_exact_for_every_angle(angle):
    axis = [[np.sin(angle), 0.0, -np.cos(angle)]]
    # The arc cosine would be wrong by 1e-8 near zero.
    assert tilt(axis, [[0.0, 0.0, 1.0]])[0] == pytest.approx(angle, rel=1e-9, abs=1e-15)


def test_only_the_speed_along_the_surface_is_feed():
    normal = np.array([[0.0, 0.6, 0.8]])
    along = np.array([[0.02, 0.0, 0.0]])
    assert tangential_speed(along + 5.0 * normal, normal) == pytest.approx([0.02])


def test_the_file_is_sorted_and_reads_back(tmp_path):
    path = tmp_path / "metrics.json"
    write_metrics(path, {"seed": np.int64(3), "force_rms_N": np.float64(0.25), "mould": "dome", "ok": True})
    text = path.read_text()
    assert json.loads(text) == {"force_rms_N": 0.25, "mould": "dome", "ok": True, "seed": 3}
    assert text.index("force") < text.index("mould") < text.index("seed")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, np.float64("nan")])
def test_a_figure_that_is_no_number_is_refused_and_leaves_the_old_file(tmp_path, value):
    path = tmp_path / "metrics.json"
    write_metrics(path, {"a": 1})
    with pytest.raises(InputError, match="force_rms_N"):
        write_metrics(path, {"force_rms_N": value})
    assert json.loads(path.read_text()) == {"a": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match="nowhere"):
        write_metrics(tmp_path / "nowhere" / "metrics.json", {"a": 1})
