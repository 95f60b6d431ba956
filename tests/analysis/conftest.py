from __future__ import annotations

import numpy as np
import pytest
import trimesh

from burnish.analysis import RemovalField, RunReport, RunSeries, Shape, tube


@pytest.fixture
def rng():
    return np.random.default_rng(20261122)


@pytest.fixture
def ball():
    def make(radius=0.1, centre=(0.0, 0.0, 0.0), colour=(0.5, 0.5, 0.5), name="ball", fineness=3, gloss=0.0):
        mesh = trimesh.creation.icosphere(fineness, radius=radius)
        return Shape(name=name, vertices=mesh.vertices + centre, faces=mesh.faces, colour=np.array(colour), gloss=gloss)

    return make


@pytest.fixture
def plate():
    """A flat mould of 100 × 60 mm, 2 µm wanted: too little on the left, right in the middle, too much right."""
    x, y = np.meshgrid(np.linspace(-0.05, 0.05, 51), np.linspace(-0.03, 0.03, 31))
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    removal = np.interp(vertices[:, 0], (-0.05, 0.05), (0.0, 4e-6))
    evaluated = np.abs(vertices[:, 1]) < 0.025
    return RemovalField(vertices=vertices, faces=faces, removal=removal, evaluated=evaluated, target=2e-6)


@pytest.fixture
def run(ball, plate):
    """A whole report on a short invented run, with its parts to be replaced."""
    t = np.arange(0.0, 3.0, 0.01)
    ones = np.ones_like(t)
    series = RunSeries(
        t=t,
        force=10.0 + np.sin(9.0 * t),
        force_set=10.0 * ones,
        tilt=0.01 * ones,
        speed=0.02 * ones,
        feed=0.02 * ones,
        phases=((0.0, "approach"), (1.0, "polish")),
    )
    line = np.stack([np.linspace(-0.05, 0.05, 20), np.zeros(20), np.full(20, 0.001)], axis=1)
    return {
        "title": "Polishing plate",
        "outcome": "done",
        "metrics": {"force_rms_N": 0.32, "coverage_pct": 98.5, "touch_peak_N": 2.4, "mould": "plate", "cycles": 300},
        "recipe": {"force_N": 10.0, "feed_mm_s": 20.0},
        "versions": {"burnish": "0.1.0"},
        "seed": 7,
        "simulated": True,
        "series": series,
        "removal": plate,
        "shapes": (ball(fineness=2), tube(line, 0.001, (0.1, 0.4, 0.7), "tool path")),
    }


@pytest.fixture
def report(run):
    """A report without pictures and plots, for tests about its words."""

    def make(**changes):
        return RunReport(**{**run, "series": None, "removal": None, "shapes": (), **changes})

    return make


@pytest.fixture
def whole_report(run):
    def make(**changes):
        return RunReport(**{**run, **changes})

    return make
