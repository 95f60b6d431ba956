"""The sliding of a spinning tip against rigid-body kinematics and the closed form for an upright one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad
from surface.shapes import box, mould

from burnish.errors import InputError
from burnish.finish.curvature import mean_curvature
from burnish.finish.removal import Removal, coverage
from burnish.finish.rubbing import MEAN_RING, Rubbing, Spindle
from burnish.rotation import exp
from burnish.surface import Mould, WorkingSurface

TIP, OMEGA, RADIUS = 0.02, 300.0, 4.2e-3
SPINDLE = Spindle(rate=OMEGA, tip_radius=TIP)
UP = np.array([[0.0, 0.0, 1.0]])


def test_leant_tip_slides_with_its_rate_times_the_offset_of_the_contact_from_the_axis() -> None:
    lean = 0.3
    axis = np.array([[-np.sin(lean), 0.0, -np.cos(lean)]])
    found = SPINDLE.rubbing(contacts=np.zeros((1, 3)), normals=UP, force=[5.0], velocity=np.zeros((1, 3)), axes=axis)
    assert np.linalg.norm(found.velocity) == pytest.approx(OMEGA * TIP * np.sin(lean))
    assert found.velocity[0, 2] == pytest.approx(0.0, abs=1e-12)
    assert found.spin[0] == pytest.approx(-OMEGA * np.cos(lean))


def test_velocity_is_that_of_a_rigid_tip_turned_by_a_small_angle() -> None:
    axis = np.array([0.4, -0.2, -1.0])
    axis /= np.linalg.norm(axis)
    feed, dt = np.array([0.02, 0.01, 0.0]), 1e-7
    centre = TIP * UP[0]
    after = centre + feed * dt + exp(OMEGA * dt * axis) @ (-centre)
    moved = after / dt
    found = SPINDLE.rubbing(contacts=np.zeros((1, 3)), normals=UP, force=[5.0], velocity=feed[None], axes=axis[None])
    np.testing.assert_allclose(found.velocity[0, :2], moved[:2], rtol=1e-4)


def test_tool_that_does_not_spin_slides_with_its_feed_alone() -> None:
    feed = np.array([[0.02, 0.0, 0.005]])
    still = Spindle(rate=0.0, tip_radius=TIP)
    found = still.rubbing(contacts=np.zeros((1, 3)), normals=UP, force=[5.0], velocity=feed, axes=-UP)
    np.testing.assert_allclose(found.velocity, [[0.02, 0.0, 0.0]])
    assert found.spin[0] == 0.0


def test_upright_tip_rubs_on_the_mean_with_three_sixteenths_pi_of_its_rim() -> None:
    assert SPINDLE.speed(RADIUS) == pytest.approx(MEAN_RING * OMEGA * RADIUS, rel=2e-3)


def test_mean_speed_of_a_leant_tip_is_the_integral_over_the_pressure() -> None:
    lean = 0.1

    def weighted(phi: float, u: float) -> float:
        across = TIP * np.sin(lean) + np.cos(lean) * RADIUS * u * np.cos(phi)
        return 1.5 / np.pi * np.sqrt(1 - u * u) * u * np.hypot(across, np.cos(lean) * RADIUS * u * np.sin(phi))

    integral = dblquad(weighted, 0.0, 1.0, 0.0, 2.0 * np.pi, epsrel=1e-6)[0]
    assert SPINDLE.speed(RADIUS, lean) == pytest.approx(OMEGA * integral, rel=2e-3)


@pytest.mark.parametrize("lean", [0.0, 0.25])
def test_spinning_parallel_tracks_remove_the_depth_of_the_text_book(lean: float) -> None:
    law = Removal(coefficient=1e-12, tip_radius=TIP, modulus=2e6)
    surface = WorkingSurface.of(Mould.of("slab", box(0.08, 0.06, 0.01)), law.edge(10.0))
    step, feed, spacing = 2e-3, 0.02, 0.2e-3
    x = np.arange(-0.05, 0.05, spacing)
    contacts = np.concatenate([np.column_stack((x, x * 0 + y, x * 0 + 0.01)) for y in np.arange(-0.03, 0.03, step)])
    normals = np.tile(UP, (len(contacts), 1))
    rubbing = SPINDLE.rubbing(
        contacts=contacts,
        normals=normals,
        force=np.full(len(contacts), 10.0),
        velocity=np.tile([feed, 0.0, 0.0], (len(contacts), 1)),
        axes=np.tile([-np.sin(lean), 0.0, -np.cos(lean)], (len(contacts), 1)),
    )
    depth = law.depth_of(surface, rubbing, np.full(len(contacts), spacing / feed))
    inner = (np.abs(surface.vertices[:, 0]) < 0.02) & (np.abs(surface.vertices[:, 1]) < 0.012)
    found = coverage(depth, 1e-9, surface.areas, inner)
    radius = 3.0 * law.edge(10.0)
    assert found.mean == pytest.approx(1e-12 * 10.0 * SPINDLE.speed(radius, lean) / (feed * step), rel=0.01)
    assert found.cv_pct < 3.0


def test_upright_tip_polishes_a_ring() -> None:
    law = Removal(coefficient=1e-12, tip_radius=TIP, modulus=2e6)
    surface = WorkingSurface.of(Mould.of("slab", box(0.03, 0.03, 0.01)), law.edge(10.0) / 3.0)
    top = np.array([[0.0, 0.0, 0.01]])
    rubbing = SPINDLE.rubbing(contacts=top, normals=UP, force=[10.0], velocity=np.zeros((1, 3)), axes=-UP)
    depth = law.depth_of(surface, rubbing, [1.0])
    away = np.linalg.norm(surface.vertices - top, axis=1)
    radius = 3.0 * law.edge(10.0)
    # p v = p₀ √(1 − s²/a²) ω s is largest at s = a/√2.
    assert away[np.argmax(depth)] == pytest.approx(radius / np.sqrt(2.0), abs=0.1 * radius)
    assert depth[np.argmin(away)] < 0.1 * depth.max()


def test_side_of_the_contact_that_runs_against_the_spin_is_rubbed_less() -> None:
    law = Removal(coefficient=1e-12, tip_radius=TIP, modulus=2e6)
    surface = WorkingSurface.of(Mould.of("slab", box(0.03, 0.03, 0.01)), 1e-3)
    slide, spin = 2.0, 300.0
    rubbing = Rubbing.of(contacts=[[0.0, 0.0, 0.01]], normals=UP, force=[10.0], velocity=[[slide, 0.0, 0.0]], spin=spin)
    depth = law.depth_of(surface, rubbing, [1.0])
    x, y = surface.vertices[:, :2].T
    one, other = (int(np.argmin(np.hypot(x, y - side))) for side in (2e-3, -2e-3))
    assert (x[one], y[one]) == pytest.approx((x[other], -y[other]))
    # n × ρ = (−y, x, 0): at +y the spin takes away from the sliding.
    fast, slow = (np.hypot(slide - spin * y[k], spin * x[k]) for k in (other, one))
    assert depth[one] / depth[other] == pytest.approx(slow / fast, rel=1e-6)


def test_rates_times_duration_are_the_depth() -> None:
    law = Removal(coefficient=1e-12, tip_radius=TIP, modulus=2e6)
    surface = WorkingSurface.of(Mould.of("slab", box(0.05, 0.03, 0.01)), 1e-3)
    x = np.linspace(-0.015, 0.015, 31)
    contacts = np.column_stack((x, 0 * x, 0 * x + 0.01))
    normals = np.tile(UP, (31, 1))
    rubbing = SPINDLE.rubbing(
        contacts=contacts, normals=normals, force=np.linspace(2, 9, 31), velocity=0 * normals, axes=-normals
    )
    dt = np.linspace(0.1, 0.3, 31)
    np.testing.assert_allclose(law.rates(surface, rubbing) @ dt, law.depth_of(surface, rubbing, dt), atol=1e-15)


def test_mean_curvature_of_the_dome_is_that_of_its_sphere() -> None:
    surface = WorkingSurface.of(mould("dome"), 1.4e-3)
    middle = np.flatnonzero(np.abs(surface.vertices[:, :2]).max(axis=1) < 0.035)[::17]
    found = mean_curvature(surface, surface.vertices[middle], surface.normals[middle], 6e-3)
    np.testing.assert_allclose(found, 1.0 / 0.15, rtol=0.1)


def test_mean_curvature_of_the_wave_is_half_of_its_cosine() -> None:
    surface = WorkingSurface.of(mould("wave"), 1.4e-3)
    for x, sign in ((0.0, 1.0), (0.03, -1.0)):
        at = int(np.argmin(np.linalg.norm(surface.vertices[:, :2] - [x, 0.0], axis=1)))
        found = mean_curvature(surface, surface.vertices[[at]], surface.normals[[at]], 6e-3)
        assert found[0] == pytest.approx(sign * 0.5 * 2e-3 * (2 * np.pi / 0.06) ** 2, rel=0.1)


@pytest.mark.parametrize("change", [{"force": [1.0, 2.0]}, {"velocity": [[np.nan, 0.0, 0.0]]}, {"contacts": [[0, 0]]}])
def test_contacts_that_do_not_fit_together_are_refused(change: dict[str, object]) -> None:
    good = {"contacts": np.zeros((1, 3)), "normals": UP, "force": [1.0], "velocity": np.zeros((1, 3))}
    with pytest.raises(InputError, match="removal"):
        Rubbing.of(**{**good, **change})
