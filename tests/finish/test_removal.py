"""Removal after Preston: the text-book depth of parallel tracks, whatever the mesh and the sampling."""

from __future__ import annotations

import numpy as np
import pytest
from surface.shapes import box, grid, mould

from burnish.core import Array
from burnish.errors import InputError
from burnish.finish.removal import Removal, coverage, edge_band, workable
from burnish.paths.reach import Reach
from burnish.surface import Mould, WorkingSurface

K, FORCE, SPEED, FEED = 1e-12, 10.0, 1.3, 0.02
LAW = Removal(coefficient=K, tip_radius=0.015, modulus=2e6)
RADIUS = 3.832e-3
SLAB = Mould.of("slab", box(0.08, 0.06, 0.01))


def tracks(offsets: Array, half_length: float = 0.05, spacing: float = 0.2e-3) -> dict[str, Array]:
    """Samples along lines in x at these y, on the slab, at a steady feed."""
    x = np.arange(-half_length, half_length, spacing)
    contacts = np.concatenate([np.column_stack((x, np.full_like(x, y), np.full_like(x, 0.01))) for y in offsets])
    one = np.ones(len(contacts))
    return {
        "contacts": contacts,
        "normals": np.tile([0.0, 0.0, 1.0], (len(contacts), 1)),
        "force": FORCE * one,
        "speed": SPEED * one,
        "dt": spacing / FEED * one,
    }


def inner(surface: WorkingSurface) -> Array:
    """Vertices of the slab well inside its borders."""
    return (np.abs(surface.vertices[:, 0]) < 0.02) & (np.abs(surface.vertices[:, 1]) < 0.012)


@pytest.mark.parametrize("step", [0.6e-3, 1.5e-3, 2.3e-3])
@pytest.mark.parametrize("edge", [RADIUS / 3, RADIUS / 5])
def test_parallel_tracks_remove_the_depth_of_the_text_book(step: float, edge: float) -> None:
    surface = WorkingSurface.of(SLAB, edge)
    depth = LAW.depth(surface, **tracks(np.arange(-0.03, 0.03, step)))
    found = coverage(depth, 1e-9, surface.areas, inner(surface))
    assert found.mean == pytest.approx(K * FORCE * SPEED / (FEED * step), rel=0.01)
    assert found.cv_pct < 2.5


def test_finer_mesh_changes_the_mean_by_less_than_one_percent() -> None:
    means = []
    for edge in (RADIUS / 3, RADIUS / 6, RADIUS / 9):
        surface = WorkingSurface.of(SLAB, edge)
        depth = LAW.depth(surface, **tracks(np.arange(-0.03, 0.03, 2e-3)))
        means.append(coverage(depth, 1e-9, surface.areas, inner(surface)).mean)
    assert np.ptp(means) < 0.01 * np.mean(means)


def test_single_track_has_the_profile_of_the_pressure_integrated_along_it() -> None:
    surface = WorkingSurface.of(SLAB, RADIUS / 8)
    depth = LAW.depth(surface, **tracks(np.array([0.0])))
    middle = np.abs(surface.vertices[:, 0]) < 0.01
    y = surface.vertices[middle, 1]
    # ∫ p0 √(1 − (x² + y²)/a²) dx = p0 (π/2) a (1 − y²/a²)
    peak = K * SPEED / FEED * 3 * FORCE / (2 * np.pi * RADIUS**2) * np.pi / 2 * RADIUS
    np.testing.assert_allclose(depth[middle], peak * np.clip(1 - (y / RADIUS) ** 2, 0, None), atol=0.03 * peak)


@pytest.mark.parametrize("spacing", [5e-6, 0.05e-3, 0.4e-3])
def test_volume_is_that_of_preston_however_often_it_was_sampled(spacing: float) -> None:
    surface = WorkingSurface.of(SLAB, RADIUS / 4)
    samples = tracks(np.array([0.0, 0.01]), half_length=0.02, spacing=spacing)
    rng = np.random.default_rng(5)
    samples["force"] = samples["force"] * rng.uniform(0.2, 1.8, len(samples["force"]))
    samples["dt"] = samples["dt"] * rng.uniform(0.5, 1.5, len(samples["dt"]))
    volume = LAW.depth(surface, **samples) @ surface.areas
    assert volume == pytest.approx(K * np.sum(samples["force"] * samples["speed"] * samples["dt"]), rel=1e-9)


def test_merging_close_samples_does_not_change_the_depth() -> None:
    surface = WorkingSurface.of(SLAB, RADIUS / 4)
    coarse, fine = (LAW.depth(surface, **tracks(np.array([0.0]), 0.02, spacing)) for spacing in (0.4e-3, 0.01e-3))
    middle = np.abs(surface.vertices[:, 0]) < 0.016  # where a track ends, the first and last group weigh
    np.testing.assert_allclose(fine[middle], coarse[middle], atol=0.04 * coarse.max())


def test_passes_add_up() -> None:
    surface = WorkingSurface.of(SLAB, RADIUS / 4)
    one, other = tracks(np.array([0.0])), tracks(np.array([0.004]))
    both = {name: np.concatenate((one[name], other[name])) for name in one}
    together, apart = LAW.depth(surface, **both), LAW.depth(surface, **one) + LAW.depth(surface, **other)
    middle = np.abs(surface.vertices[:, 0]) < 0.03
    np.testing.assert_allclose(together[middle], apart[middle], atol=0.02 * apart.max())  # samples group differently


def test_overhanging_tip_presses_harder_but_at_most_twice() -> None:
    surface = WorkingSurface.of(SLAB, RADIUS / 6)
    at_edge, outside, middle = (LAW.depth(surface, **tracks(np.array([y]))) for y in (0.03, 0.0335, 0.0))
    centre = np.abs(surface.vertices[:, 0]) < 0.02
    assert at_edge[centre].max() == pytest.approx(2 * middle[centre].max(), rel=0.08)
    assert outside[centre].max() < 0.5 * at_edge[centre].max()


def test_only_what_faces_the_tool_is_removed() -> None:
    # The underside of a plate 2 mm thick lies within the contact and must stay as it is.
    thin = Mould.of("thin", box(0.06, 0.06, 0.002))
    vertices, faces = WorkingSurface.of(thin, 1e-3).vertices, WorkingSurface.of(thin, 1e-3).faces
    both = WorkingSurface(
        vertices=np.concatenate((vertices, vertices * [1, 1, 0])),
        faces=np.concatenate((faces, faces[:, ::-1] + len(vertices))),
    )
    samples = tracks(np.array([0.0]), 0.02)
    samples["contacts"] = samples["contacts"] - [0, 0, 0.008]
    depth = LAW.depth(both, **samples)
    assert depth[: len(vertices)].max() > 0
    assert depth[len(vertices) :].max() == 0


def test_without_force_nothing_is_removed() -> None:
    surface = WorkingSurface.of(SLAB, 2e-3)
    samples = tracks(np.array([0.0]))
    samples["force"] = 0.0 * samples["force"]
    assert not LAW.depth(surface, **samples).any()


def test_lifting_between_two_tracks_removes_nothing_between_them() -> None:
    surface = WorkingSurface.of(SLAB, 1e-3)
    depth = LAW.depth(surface, **tracks(np.array([-0.02, 0.02]), 0.02))
    assert not depth[np.abs(surface.vertices[:, 1]) < 0.015].any()


@pytest.mark.parametrize(
    "change", [{"force": np.ones(3)}, {"contacts": np.zeros((500, 2))}, {"dt": np.full(500, np.nan)}]
)
def test_samples_that_do_not_fit_together_are_refused(change: dict[str, Array]) -> None:
    samples = {**tracks(np.array([0.0])), **change}
    with pytest.raises(InputError, match="removal"):
        LAW.depth(WorkingSurface.of(SLAB, 5e-3), **samples)


@pytest.mark.parametrize("constants", [(0.0, 0.015, 2e6), (1e-12, -1.0, 2e6), (1e-12, 0.015, np.nan)])
def test_constants_of_no_tool_are_refused(constants: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="expected positive"):
        Removal(coefficient=constants[0], tip_radius=constants[1], modulus=constants[2])


def test_working_surface_resolves_the_contact_in_thirds() -> None:
    assert LAW.edge(FORCE) == pytest.approx(RADIUS / 3, rel=1e-3)


def test_coverage_weighs_by_area_and_counts_only_what_it_is_asked_for() -> None:
    depth = np.array([0.4, 0.6, 1.6, 9.0])
    found = coverage(depth, 1.0, np.array([1.0, 2.0, 1.0, 5.0]), np.array([True, True, True, False]))
    assert found.covered_pct == pytest.approx(75.0)
    assert found.overpolished_pct == pytest.approx(25.0)
    assert found.mean == pytest.approx(0.8)
    assert found.cv_pct == pytest.approx(100 * np.sqrt((0.16 + 2 * 0.04 + 0.64) / 4) / 0.8)


def test_limits_of_coverage_are_half_and_one_and_a_half() -> None:
    found = coverage(np.array([0.5, 1.5]), 1.0, np.ones(2), np.ones(2, dtype=bool))
    assert (found.covered_pct, found.overpolished_pct) == (100.0, 0.0)


@pytest.mark.parametrize(("target", "counts"), [(0.0, True), (1.0, False)])
def test_coverage_of_nothing_is_refused(target: float, counts: bool) -> None:
    with pytest.raises(InputError, match="coverage"):
        coverage(np.ones(3), target, np.ones(3), np.full(3, counts))


def test_edge_band_of_the_slab_is_its_rim() -> None:
    surface = WorkingSurface.of(SLAB, 1e-3)
    rim = np.abs(surface.vertices[:, :2]) > np.array([0.04, 0.03]) - 5.1e-3
    np.testing.assert_array_equal(edge_band(SLAB, surface.vertices, 5.1e-3), rim.any(axis=1))


def test_workable_part_of_the_mould_leaves_out_wall_hole_rim_and_steep_fillet() -> None:
    surface = WorkingSurface.of(mould("mould"), 1.2e-3)
    reach = Reach.of(mould("mould"), grid("mould"), tip_radius=0.015, margin=5e-3)
    good = workable(surface, reach)
    x, y = surface.vertices[:, :2].T
    assert not good[np.hypot(x - 0.035, y - 0.0125) < 0.0119].any()
    assert not good[y < -0.037].any()
    wall = (np.abs(x + 0.021875) < 0.024) & (np.abs(y - 0.005) < 0.017) & (np.abs(y - 0.005) > 0.012)
    assert not good[wall].any()
    assert good[(np.abs(y + 0.025) < 0.005) & (np.abs(x) < 0.05)].all()
    assert good[np.hypot(x + 0.021875, y - 0.005) < 0.003].all()
