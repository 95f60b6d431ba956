from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.inertia import Body, combine, hoop, solid_cylinder
from burnish.model.jaco2_parts import jaco2_augmented_links, jaco2_links, jaco2_parts

PARTS = [part for parts in jaco2_parts() for part in parts]


def cloud(seed: int, points: int = 40) -> tuple[Array, Array]:
    """Masses and places of some points: a body whose moments can be summed by hand."""
    random = np.random.default_rng(seed)
    return random.uniform(0.01, 0.2, points), random.normal(size=(points, 3)) * (0.05, 0.1, 0.2) + random.normal(size=3)


def body_of(mass: Array, at: Array, name: str = "cloud") -> Body:
    """The body that point masses make, by the definition of mass, centre and inertia."""
    com = mass @ at / mass.sum()
    r = at - com
    inertia = np.einsum("i,iab->ab", mass, np.einsum("ia,ia,bc->ibc", r, r, np.eye(3)) - np.einsum("ia,ib->iab", r, r))
    return Body(name=name, mass=float(mass.sum()), com=com, inertia=inertia)


def test_combined_bodies_are_the_body_of_all_their_points() -> None:
    (m1, p1), (m2, p2), (m3, p3) = (cloud(seed) for seed in (1, 2, 3))
    whole = body_of(np.concatenate((m1, m2, m3)), np.vstack((p1, p2, p3)))
    together = combine([body_of(m1, p1), body_of(m2, p2), body_of(m3, p3)], "all")
    assert together.mass == pytest.approx(whole.mass, rel=1e-15)
    np.testing.assert_allclose(together.com, whole.com, atol=1e-14)
    np.testing.assert_allclose(together.tensor, whole.tensor, atol=1e-12)


def test_summed_mass_in_the_parallel_axis_theorem_as_thesis_a_prints_it_is_not_that_body() -> None:
    link, actuator = body_of(*cloud(1)), body_of(*cloud(2))
    whole = combine([link, actuator], "augmented")
    printed = sum(replace(body, mass=whole.mass).tensor_about(whole.com) for body in (link, actuator))
    np.testing.assert_allclose(sum(body.tensor_about(whole.com) for body in (link, actuator)), whole.tensor)
    assert np.abs(printed - whole.tensor).max() > 0.1 * np.abs(whole.tensor).max()


def test_body_seen_from_another_frame_is_the_body_of_the_moved_points() -> None:
    mass, at = cloud(4)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler("xyz", (0.3, -1.1, 2.0)).as_matrix(), (0.4, -0.2, 0.9)
    seen, moved = body_of(mass, at).seen_from(T), body_of(mass, at @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(seen.com, moved.com, atol=1e-14)
    np.testing.assert_allclose(seen.tensor, moved.tensor, atol=1e-13)
    np.testing.assert_allclose(seen.inertia, body_of(mass, at).inertia, atol=0)  # only its axes have turned


def test_inertia_in_its_own_axes_is_turned_into_the_frame() -> None:
    axes = Rotation.from_euler("z", np.pi / 2).as_matrix()
    body = Body(name="bar", mass=1.0, com=np.zeros(3), inertia=np.diag((0.1, 1.0, 1.05)), axes=axes)
    np.testing.assert_allclose(body.tensor, np.diag((1.0, 0.1, 1.05)), atol=1e-15)


def test_cylinder_and_hoop_are_what_integration_over_their_points_gives() -> None:
    axis, d, length = np.array([0.0, 0.6, 0.8]), 0.07, 0.06
    turn = Rotation.align_vectors([axis], [[0.0, 0.0, 1.0]])[0].as_matrix()
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    r2, w_r = np.polynomial.legendre.leggauss(4)  # exact for the polynomials in question
    z, w_z = np.polynomial.legendre.leggauss(4)
    radius = d / 2 * np.sqrt((r2 + 1) / 2)
    grid = np.array([(r * np.cos(a), r * np.sin(a), h * length / 2) for r in radius for h in z for a in angle])
    weights = 1.3 * np.repeat(np.outer(w_r, w_z).ravel() / 4, len(angle)) / len(angle)
    solid = solid_cylinder(name="c", mass=1.3, com=np.ones(3), axis=axis, diameter=d, length=length)
    np.testing.assert_allclose(solid.tensor, body_of(weights, grid @ turn.T).tensor, atol=1e-15)
    rim = np.column_stack((d / 2 * np.cos(angle), d / 2 * np.sin(angle), 0 * angle))
    ring = hoop(name="h", mass=0.4, com=np.ones(3), axis=axis, diameter=d)
    np.testing.assert_allclose(ring.tensor, body_of(np.full(16, 0.4 / 16), rim @ turn.T).tensor, atol=1e-15)


@pytest.mark.parametrize("index", range(7), ids=lambda i: f"link_{i}")
def test_augmented_link_from_its_parts_is_the_link_that_the_models_use(index: int) -> None:
    built, used = jaco2_augmented_links()[index], jaco2_links()[index]
    assert built.mass == pytest.approx(used.mass, abs=1e-12)
    assert np.linalg.norm(built.com - used.com) < 1e-3
    scale = np.sqrt(np.outer(np.diag(used.tensor), np.diag(used.tensor)))
    assert np.abs((built.tensor - used.tensor) / scale).max() < 0.01
    given = np.abs(used.tensor) > 0
    assert np.abs(built.tensor[given] / used.tensor[given] - 1).max() < 0.01  # each printed number, products too


def test_only_link_3_needed_to_be_moved() -> None:
    for index, (built, used) in enumerate(zip(jaco2_augmented_links(), jaco2_links(), strict=True)):
        exact = np.linalg.norm(built.com - used.com) < 1e-6 and np.allclose(built.tensor, used.tensor, atol=1e-7)
        assert exact == (index != 3)


def test_shell_that_link_3_leaves_is_not_a_body() -> None:
    link, (_, actuator, ring) = jaco2_links()[3], jaco2_parts()[3]
    mass = link.mass - actuator.mass - ring.mass
    com = (link.mass * link.com - actuator.mass * actuator.com - ring.mass * ring.com) / mass
    far = [part.tensor_about(link.com) for part in (actuator, ring)]
    r = com - link.com
    left = link.tensor - sum(far, np.zeros((3, 3))) - mass * (r @ r * np.eye(3) - np.outer(r, r))
    np.testing.assert_allclose(np.linalg.eigvalsh(left), [75e-6, 660e-6, 796e-6], atol=1e-6)
    with pytest.raises(InputError, match="at most the sum"):
        Body(name="shell 3", mass=mass, com=com, inertia=left)


def test_hand_from_palm_and_fingers_owes_its_tensor_to_no_decomposition() -> None:
    hand, parts = jaco2_links()[6], jaco2_parts()[6]
    assert len(parts) == 7
    np.testing.assert_allclose(combine(parts, "hand").tensor, hand.tensor, atol=1e-8)


def test_arm_weighs_what_thesis_a_and_the_data_sheet_say() -> None:
    grams = [1000 * part.mass for part in PARTS if part.name.startswith("shell")][1:]
    assert grams == pytest.approx([181.984, 423.993, 211.004, 68.96, 68.96])
    without_hand = sum(link.mass for link in jaco2_links()[:6])
    assert without_hand == pytest.approx(4.4, rel=0.005)
    assert without_hand + jaco2_links()[6].mass == pytest.approx(5.2, rel=0.02)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_every_part_is_physical_and_not_absurdly_large(part: Body) -> None:
    a, b, c = np.linalg.eigvalsh(part.tensor)
    assert part.mass > 0
    assert a > 0
    assert a + b >= c * (1 - 1e-9)
    assert np.sqrt(c / part.mass) < 0.17  # radius of gyration [m]; the longest shell has 0.4 m


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": 0.0}, "mass"),
        ({"mass": -3.0}, "mass"),
        ({"mass": np.nan}, "mass"),
        ({"com": np.zeros(2)}, "com"),
        ({"com": np.array([0.0, np.inf, 0.0])}, "com"),
        ({"inertia": np.diag((1.0, 1.0, 2.1))}, "sum of the others"),
        ({"inertia": np.diag((1.0, 1.0, 0.0))}, "above 0"),
        ({"inertia": np.array([[1.0, 0.1, 0], [0, 1, 0], [0, 0, 1]])}, "symmetric"),
        ({"axes": -np.eye(3)}, "rotation"),
    ],
)
def test_body_that_cannot_be_is_refused(change: dict[str, object], message: str) -> None:
    good = {"name": "b", "mass": 1.0, "com": np.zeros(3), "inertia": np.eye(3)}
    with pytest.raises(InputError, match=message):
        Body(**{**good, **change})  # type: ignore[arg-type]


def test_nothing_cannot_be_combined() -> None:
    with pytest.raises(InputError, match="no body"):
        combine([], "nothing")


def test_table_in_the_docs_is_what_the_code_has() -> None:
    page = (Path(__file__).parents[2] / "docs" / "jaco2-inertia.md").read_text(encoding="utf-8")
    cells = [[cell.strip().replace("−", "-") for cell in line.strip("|").split("|")] for line in page.splitlines()]
    rows = [row for row in cells if len(row) == 11 and re.fullmatch(r"-?[\d.]+", row[1])]
    bodies = [*jaco2_links(), *PARTS]
    assert len(rows) == len(bodies)
    for row, body in zip(rows, bodies, strict=True):
        I = body.tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        printed = np.array([float(cell) for cell in row[1:]])
        assert body.name in row[0]
        np.testing.assert_allclose(printed, [1e3 * body.mass, *(1e3 * body.com), *(1e6 * I)], atol=0.051, rtol=0)
        np.testing.assert_allclose(printed[:4], [1e3 * body.mass, *(1e3 * body.com)], atol=0.0051, rtol=0)
