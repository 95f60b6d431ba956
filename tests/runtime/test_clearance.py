"""The arm's distance from itself, against another engine's; and the arm's shapes, against what it is drawn with."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import combinations, pairwise

import coal
import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from scipy.spatial import cKDTree

from burnish.core import Array, Dynamics, State
from burnish.errors import InputError
from burnish.model.looks import looks
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.runtime.clearance import Clearance, segment_distance
from burnish.runtime.limits import Limits

MODEL = Model.jaco2()
LIMITS = Limits.jaco2()
HOME = np.array([4.8046852, 2.924825, 1.002, 4.2031852, 1.4458, 1.3233])
LINKS = ["link_base", "link_1", "link_2", "link_3", "link_4", "link_5", "link_6"]
"""One capsule each, in this order."""


def arm_at(q: Array, model: Model = MODEL) -> Dynamics:
    return model.at(State(t=0.0, q=q, dq=np.zeros(6)))


def samples(count: int) -> Array:
    rng = np.random.default_rng(3)
    low = np.where(np.isfinite(LIMITS.lower), LIMITS.lower, -2.0 * np.pi)
    high = np.where(np.isfinite(LIMITS.upper), LIMITS.upper, 2.0 * np.pi)
    return rng.uniform(low, high, (count, 6))


@lru_cache
def zero() -> dict[str, Array]:
    return MODEL.link_poses(np.zeros(6))


def placed_ends(q: Array, model: Model) -> list[tuple[Array, Array]]:
    """Both ends of each capsule by the poses of the links."""
    now, ends = model.link_poses(q), []
    for row in LIMITS.capsules:
        name = LINKS[int(row[0])]
        move = now[name] @ np.linalg.inv(zero()[name])
        ends.append((move[:3, :3] @ row[1:4] + move[:3, 3], move[:3, :3] @ row[4:7] + move[:3, 3]))
    return [*ends[:-1], (ends[-1][0], model.kinematics(q)[0])]


def capsule(ends: tuple[Array, Array], radius: float) -> tuple[coal.Capsule, coal.Transform3s]:
    a, b = ends
    length = float(np.linalg.norm(b - a))
    z = (b - a) / length
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return coal.Capsule(radius, length), coal.Transform3s(np.column_stack([x, np.cross(z, x), z]), 0.5 * (a + b))


def theirs(q: Array, model: Model) -> float:
    return float(their_pairs(q, model).min())


def their_pairs(q: Array, model: Model = MODEL) -> Array:
    """The distance of each pair; of two that run into each other, not by how much."""
    ends, found = placed_ends(q, model), []
    for a, b in LIMITS.pairs.astype(int):
        result = coal.DistanceResult()
        first, second = capsule(ends[a], LIMITS.capsules[a, 7]), capsule(ends[b], LIMITS.capsules[b, 7])
        coal.distance(*first, *second, coal.DistanceRequest(), result)
        found.append(result.min_distance)
    return np.array(found)


@pytest.mark.parametrize("model", [MODEL, PolishingTool().on(MODEL)], ids=["bare", "with tool"])
def test_distance_is_that_of_another_engine(model: Model) -> None:
    clearance = Clearance(LIMITS)
    apart = [(q, distance) for q in samples(150) if (distance := theirs(q, model)) > 0.0]
    assert len(apart) > 50
    assert_allclose([clearance.measure(arm_at(q, model)) for q, _ in apart], [d for _, d in apart], atol=1e-8)


@pytest.mark.parametrize("step", [0.002, 0.02, 0.2])
def test_bound_is_never_more_than_the_distance_where_it_matters(step: float) -> None:
    rng = np.random.default_rng(4)
    clearance, exact = Clearance(LIMITS), Clearance(LIMITS)
    near = 0
    for start in samples(20):
        q = start
        for _ in range(60):
            q = q + step * rng.normal(size=6)
            arm = arm_at(q)
            bound, true = clearance.at(arm), exact.measure(arm)
            assert bound <= true + 1e-9
            # It is the distance itself where the arm would be braked.
            assert bound == pytest.approx(true) if true < LIMITS.self_slow else bound >= LIMITS.self_slow
            near += true < LIMITS.self_slow
    assert near > 0


def test_still_arm_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    clearance, calls = Clearance(LIMITS), []
    measure = clearance.measure
    monkeypatch.setattr(clearance, "measure", lambda arm: calls.append(arm) or measure(arm))
    for k in range(50):
        clearance.at(arm_at(HOME + 1e-4 * k))
    assert len(calls) == 1


@pytest.mark.parametrize("near", [0.05, 0.12, np.inf])
def test_of_the_pairs_that_are_near_the_first_to_get_too_near_says_way_and_speed(near: float) -> None:
    rng = np.random.default_rng(6)
    clearance, closed, late = Clearance(LIMITS, near=near), 0, 0
    step = 1e-5
    for q in samples(300):
        dq = 0.3 * rng.normal(size=6)
        before, now, after = their_pairs(q - step * dq), their_pairs(q), their_pairs(q + step * dq)
        watched = np.flatnonzero(now < near)
        if len(watched) == 0 or now.min() < LIMITS.self_stop:
            continue
        way, speed = clearance.closing(arm_at(q))(dq)
        ways, speeds = now[watched] - LIMITS.self_slow, (before - after)[watched] / (2.0 * step)
        first = np.argmax(np.where(speeds > 0.0, speeds / np.maximum(ways, 1e-6), -ways))
        assert way == pytest.approx(ways[first], abs=1e-8)
        # The difference is off by its curvature, and by the other engine's 1e-8 m.
        assert speed == pytest.approx(speeds[first], abs=3e-3)
        closed += speed > 0.01
        late += first != np.argmin(now[watched])
    assert closed > 5
    assert late > 0 or near < 0.1, "the nearest pair was always the first"


def test_capsules_whose_axes_cross_have_a_distance_and_no_direction() -> None:
    rng = np.random.default_rng(7)
    clearance = Clearance(replace(LIMITS, capsules=LIMITS.capsules * np.array([1.0, *[0.0] * 6, 1.0])), near=np.inf)
    for q in samples(20):
        assert np.isfinite(clearance.closing(arm_at(q))(rng.normal(size=6))).all()


def test_far_from_itself_the_arm_closes_nothing() -> None:
    assert Clearance(LIMITS).closing(arm_at(HOME))(np.ones(6)) == (np.inf, 0.0)


def test_arm_without_shapes_is_never_near_itself() -> None:
    assert Clearance(Limits.of(MODEL)).at(arm_at(HOME)) == np.inf


def test_axes_of_the_packaged_file_are_those_of_the_model() -> None:
    for i, axis in enumerate(LIMITS.axes):
        pose = zero()[f"link_{i + 1}"]
        assert_allclose(axis, np.concatenate([pose[:3, 2], pose[:3, 3]]), atol=1e-8)


def test_axis_of_any_length_is_a_direction() -> None:
    longer = replace(LIMITS, axes=LIMITS.axes * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]))
    assert Clearance(longer).measure(arm_at(HOME)) == pytest.approx(Clearance(LIMITS).measure(arm_at(HOME)))


def test_capsules_hold_what_the_arm_is_drawn_with() -> None:
    for look in looks():
        pose = zero()[look.link]
        points = look.vertices @ pose[:3, :3].T + pose[:3, 3]
        out = []
        for row in LIMITS.capsules:
            a, along = row[1:4], row[4:7] - row[1:4]
            share = np.clip((points - a) @ along / (along @ along), 0.0, 1.0)
            out.append(np.linalg.norm(points - a - share[:, None] * along, axis=1) - row[7])
        # The foot of the base is a flange on the table.
        assert np.min(out, axis=0).max() < (0.015 if look.link == "link_base" else 0.0)


@pytest.mark.slow
def test_pairs_that_are_not_looked_at_cannot_meet() -> None:
    rng = np.random.default_rng(5)
    points: dict[str, list[Array]] = {}
    for look in looks():
        mesh = trimesh.Trimesh(look.vertices, look.faces, process=False)
        dots = trimesh.sample.sample_surface(mesh, 150, seed=1)[0]
        points.setdefault(look.link, []).append(np.vstack([look.vertices, dots]))
    checked = {tuple(pair) for pair in LIMITS.pairs.astype(int).tolist()}
    low, high = LIMITS.within(LIMITS.hard_margin, 1.0 / 30.0)
    neighbours = set(pairwise(range(7)))
    for a, b in sorted(set(combinations(range(7), 2)) - checked - neighbours):
        least = np.inf
        for _ in range(400):
            q = np.where(np.isfinite(low), rng.uniform(np.maximum(low, -9.0), np.minimum(high, 9.0)), 0.0)
            q = np.where(np.isfinite(low), q, rng.uniform(0.0, 2.0 * np.pi, 6))
            poses = MODEL.link_poses(q)
            first, second = (
                np.vstack(points[link]) @ poses[link][:3, :3].T + poses[link][:3, 3] for link in (LINKS[a], LINKS[b])
            )
            least = min(least, float(cKDTree(first).query(second)[0].min()))
        assert least > LIMITS.self_slow, (a, b)


# Segments.


def sampled(a: Array, b: Array, c: Array, d: Array) -> float:
    """Over all pairs of many points of both."""
    share = np.linspace(0.0, 1.0, 401)[:, None]
    first, second = a + share * (b - a), c + share * (d - c)
    return float(cKDTree(first).query(second)[0].min())


@pytest.mark.parametrize("seed", range(40))
def test_segment_distance_is_the_least_over_both(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, c, d = rng.normal(size=(4, 3)) * 10.0 ** rng.uniform(-1.0, 1.0, (4, 1))
    found = segment_distance(a.tolist(), b.tolist(), c.tolist(), d.tolist())
    true = sampled(a, b, c, d)
    spacing = (np.linalg.norm(b - a) + np.linalg.norm(d - c)) / 400.0
    assert true - spacing <= found <= true + 1e-9


O, X, Y, Z = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
SEGMENTS = {
    "two points": ((O, O, Z, Z), 1.0),
    "a point beside a segment": (([0.3, 2.0, 0.0],) * 2 + (O, X), 2.0),
    "a segment beside a point": ((O, X) + ([0.3, 2.0, 0.0],) * 2, 2.0),
    "parallel, side by side": ((O, X, Y, [1.0, 1.0, 0.0]), 1.0),
    "parallel, one after the other": ((O, X, [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]), 2.0),
    "against each other": ((O, X, [4.0, 0.0, 0.0], [3.0, 0.0, 0.0]), 2.0),
    "crossing": ((O, X, [0.5, -1.0, 0.0], [0.5, 1.0, 0.0]), 0.0),
    "askew": ((O, X, [0.5, -1.0, 0.7], [0.5, 1.0, 0.7]), 0.7),
}


@pytest.mark.parametrize("case", SEGMENTS)
def test_segment_distance_of_special_cases(case: str) -> None:
    ends, expected = SEGMENTS[case]
    assert segment_distance(*ends) == pytest.approx(expected)


# The tables.

BAD = {
    "axes of another width": {"axes": np.ones((6, 5))},
    "capsules of another width": {"capsules": np.ones((6, 7))},
    "a vector for a table": {"pairs": np.ones(2)},
    "too few axes": {"axes": LIMITS.axes[:5]},
    "a joint that there is not": {"capsules": LIMITS.capsules + np.eye(7, 8) * 7.0},
    "half a joint": {"capsules": LIMITS.capsules + np.eye(7, 8) * 0.5},
    "the last capsule on another joint": {"capsules": LIMITS.capsules[:6], "pairs": np.zeros((0, 2))},
    "no radius": {"capsules": LIMITS.capsules * np.array([1.0] * 7 + [0.0])},
    "a capsule that there is not": {"pairs": [[0, 7]]},
    "pairs without capsules": {"capsules": []},
    "no number": {"axes": LIMITS.axes * np.nan},
    "endless": {"axes": LIMITS.axes + np.inf},
    "slow at no more than stop": {"self_slow": 0.01},
}


@pytest.mark.parametrize("case", BAD)
def test_tables_that_make_no_sense_are_refused(case: str) -> None:
    with pytest.raises(InputError, match="limits: "):
        replace(LIMITS, **BAD[case])
