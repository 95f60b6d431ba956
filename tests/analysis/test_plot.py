from __future__ import annotations

import numpy as np
import pytest

from burnish.analysis import RemovalField, RunSeries, removal_colours
from burnish.analysis.mould_map import coverage_map, removal_histogram, removal_map
from burnish.analysis.plot import classes, envelope, motion_figure, png_data, svg, vertex_areas
from burnish.errors import InputError


def test_the_envelope_keeps_a_spike_of_one_sample_in_a_long_run():
    t = np.linspace(0.0, 600.0, 600_001)
    y = np.sin(t)
    y[123_456], y[400_001] = 37.0, -41.0
    few_t, few = envelope(t, y, bins=900)
    assert len(few) <= 1800
    assert (few.max(), few.min()) == (37.0, -41.0)
    assert few_t[np.argmax(few)] == t[123_456]
    assert (np.diff(few_t) >= 0.0).all()


def test_the_envelope_contains_only_samples_and_all_extremes(rng):
    t, y = np.arange(10_007.0), rng.normal(size=10_007)
    few_t, few = envelope(t, y, bins=100)
    assert np.array_equal(y[few_t.astype(int)], few)
    pieces = np.split(y, np.linspace(0, len(t), 101).astype(int)[1:-1])
    assert np.allclose(np.sort(few), np.sort([f(p) for p in pieces for f in (np.min, np.max)]))


def test_a_short_line_is_left_alone():
    t = np.arange(50.0)
    assert envelope(t, t, bins=25)[0] is t


def test_gaps_stay_gaps():
    y = np.ones(10_000)
    y[2_000:6_000] = np.nan
    few_t, few = envelope(np.arange(10_000.0), y, bins=100)
    assert np.isnan(few[(few_t > 2_100) & (few_t < 5_900)]).all()
    assert (few[(few_t < 1_900) | (few_t > 6_100)] == 1.0).all()


def test_classes_split_at_half_and_at_one_and_a_half_times_the_target():
    removal = np.array([0.0, 0.49, 0.5, 1.0, 1.5, 1.51, 9.0])
    inside = np.array([True] * 6 + [False])
    assert classes(removal, inside, 1.0).tolist() == [0, 0, 1, 1, 1, 2, 3]


def test_vertex_areas_add_up_to_the_area_of_the_mesh(plate):
    areas = vertex_areas(plate.vertices, plate.faces)
    assert areas.sum() == pytest.approx(0.1 * 0.06)
    # An inner vertex owns one cell of 2 × 2 mm.
    assert np.median(areas) == pytest.approx(4e-6)


def test_the_top_view_interpolates_linear_values_exactly(plate):
    image = plate.view.image(plate.removal)
    left, right, bottom, top = plate.view.extent_mm
    assert (left, bottom) == pytest.approx((-50.0, -30.0))
    assert right == pytest.approx(50.0, abs=0.2)
    assert top == pytest.approx(30.0, abs=0.2)
    width = image.shape[1]
    x = left + (np.arange(width) + 0.5) * (right - left) / width
    inner = image[2:-2, 2:-2]
    assert np.allclose(inner, np.interp(x, (-50, 50), (0, 4e-6))[2:-2], atol=1e-14)


def test_the_top_view_shows_the_upper_of_two_sheets(plate):
    below = plate.vertices - (0.0, 0.0, 0.01)
    both = RemovalField(
        vertices=np.concatenate([below, plate.vertices]),
        faces=np.concatenate([plate.faces, plate.faces + len(below)]),
        removal=np.concatenate([np.full(len(below), 1.0), plate.removal]),
        evaluated=np.concatenate([plate.evaluated, plate.evaluated]),
        target=plate.target,
    )
    assert np.nanmax(both.view.image(both.removal)) < 1e-5


def test_the_coverage_bar_names_the_shares_of_the_area(plate):
    figure = coverage_map(plate)
    figure.draw_without_rendering()
    labels = [label.get_text() for axes in figure.axes for label in axes.get_xticklabels()]
    # A linear ramp from 0 to twice the target: a quarter, a half, a quarter, up to one row of vertices.
    shares = [float(text.split("\n")[1].split()[0]) for text in labels if "\n" in text]
    assert shares == pytest.approx([25.0, 50.0, 25.0], abs=2.0)
    assert sum(shares) == pytest.approx(100.0, abs=0.2)


def test_the_histogram_holds_the_whole_evaluated_area(plate):
    axes = removal_histogram(plate).axes[0]
    assert sum(bar.get_height() for bar in axes.patches) == pytest.approx(100.0)


def test_every_axis_has_a_unit(plate, run):
    for figure in (motion_figure(run["series"]), removal_map(plate), coverage_map(plate), removal_histogram(plate)):
        for axes in figure.axes:
            for label in (axes.get_xlabel(), axes.get_ylabel()):
                assert not label or "[" in label or "share" in label


def test_an_svg_names_nothing_outside_itself(run):
    text = svg(motion_figure(run["series"]), "motion")
    assert text.startswith("<svg")
    assert "<metadata" not in text
    assert "<!DOCTYPE" not in text
    assert 'href="http' not in text


def test_an_svg_of_a_long_run_stays_small(rng):
    t = np.arange(0.0, 300.0, 0.001)
    noise = rng.normal(size=t.size)
    series = RunSeries(
        t=t, force=10 + noise, force_measured=10 + 2 * noise, force_set=t * 0 + 10, tilt=noise, speed=noise, feed=noise
    )
    assert len(svg(motion_figure(series), "motion")) < 600_000


def test_drawing_leaves_no_global_state(plate):
    import matplotlib

    before = dict(matplotlib.rcParams)
    png_data(removal_map(plate))
    svg(removal_histogram(plate), "x")
    assert dict(matplotlib.rcParams) == before


def test_colours_for_a_scene_are_one_a_vertex(plate):
    colours = removal_colours(plate)
    assert colours.shape == (len(plate.vertices), 3)
    assert colours.min() >= 0.0
    assert colours.max() <= 1.0


def test_series_of_different_lengths_are_refused(run):
    with pytest.raises(InputError, match="tilt"):
        RunSeries(
            t=np.zeros(4), force=np.zeros(4), force_set=np.zeros(4), tilt=np.zeros(3), speed=[0] * 4, feed=[0] * 4
        )


@pytest.mark.parametrize("wrong", [{"target": 0.0}, {"removal": np.zeros(3)}, {"faces": np.zeros((0, 3), int)}])
def test_a_field_without_sense_is_refused(plate, wrong):
    good = {name: getattr(plate, name) for name in ("vertices", "faces", "removal", "evaluated", "target")}
    with pytest.raises(InputError, match="RemovalField"):
        RemovalField(**{**good, **wrong})


def test_a_series_with_nothing_in_contact_still_draws():
    t = np.arange(0.0, 1.0, 0.01)
    nothing = np.full_like(t, np.nan)
    series = RunSeries(t=t, force=0 * t, force_set=nothing, tilt=nothing, speed=nothing, feed=nothing)
    assert svg(motion_figure(series), "motion").startswith("<svg")
