"""What a pass teaches the next one about the height of the surface."""

from __future__ import annotations

import numpy as np

from burnish.paths.stroke import Stroke
from burnish.polish.learn import MOST, Learner, smoothed
from burnish.polish.passes import Leg

X = np.arange(0.0, 0.1001, 0.5e-3)


def leg() -> Leg:
    n = np.tile([0.0, 0.0, 1.0], (len(X), 1))
    path = Stroke(
        points=np.column_stack([X, 0 * X, 0 * X]), normals=n, feed=np.full(len(X), 0.02), force=np.full(len(X), 10.0)
    )
    return Leg(number=1, stroke=1, path=path)


def ridge(s: np.ndarray) -> np.ndarray:
    return 1e-3 * np.exp(-0.5 * ((s - 0.05) / 0.02) ** 2)


def worked(learner: Learner, error: float) -> None:
    """A pass over a surface with a ridge: the tool rides on it, 0.8 mm into its spring."""
    at = learner.corrected(leg())
    height = ridge(X) - 0.8e-3 - at.path.points[:, 2]
    for s, h in zip(X, height, strict=True):
        learner.add(at, float(s), float(h), error)
    learner.end(at)


def test_learner_without_a_gain_changes_nothing() -> None:
    learner, one = Learner(), leg()
    worked(learner, 1.0)
    assert learner.corrected(one) is one


def test_shape_of_the_surface_is_learnt_and_not_its_height() -> None:
    learner = Learner(gain=0.7, forgetting=0.0)
    for error in (0.5, 0.4, 0.35, 0.34):
        worked(learner, error)
    found = learner.corrected(leg()).path.points[:, 2]
    wanted = ridge(X) - ridge(X).mean()
    # The smoothing takes 15 % off a ridge of 20 mm, and mirrors at the ends.
    assert np.abs(found - wanted).max() < 0.2e-3


def test_correction_of_a_worse_pass_is_undone_for_good() -> None:
    learner = Learner(gain=0.7)
    worked(learner, 0.5)
    worked(learner, 0.4)
    best = None
    worked(learner, 0.45)
    assert learner.undone == 1
    best = learner.corrected(leg()).path.points
    worked(learner, 0.1)
    assert np.array_equal(learner.corrected(leg()).path.points, best)


def test_correction_is_bounded() -> None:
    learner = Learner(gain=1.0)
    for s in X:
        learner.add(leg(), float(s), float(0.1 * np.sin(60.0 * s)), 0.1)
    learner.end(leg())
    assert np.abs(learner.corrected(leg()).path.points[:, 2]).max() <= MOST


def test_smoothing_shifts_nothing() -> None:
    values = np.exp(-0.5 * ((np.arange(101) - 50) / 6.0) ** 2)
    found = smoothed(values)
    assert np.allclose(found, found[::-1])
    assert int(found.argmax()) == 50
