"""Samples with random numbers, and small recordings of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from burnish.core import Dynamics, JointReference, Sample, ToolReference
from burnish.record.recorder import Recorder

NAMES = ("one", "two", "three", "four", "five", "six")


def random_arm(rng: np.random.Generator, t: float, *, F: bool = True, tau: bool = True) -> Dynamics:
    return Dynamics(
        t=t,
        q=rng.normal(size=6),
        dq=rng.normal(size=6),
        p=rng.normal(size=3),
        R=Rotation.random(random_state=rng).as_matrix(),
        J=np.zeros((6, 6)),
        dJdq=np.zeros(6),
        M=np.eye(6),
        h=np.zeros(6),
        g=np.zeros(6),
        tau=rng.normal(size=6) if tau else None,
        F=rng.normal(size=6) if F else None,
    )


def tool_sample(rng: np.random.Generator, t: float, **has: bool) -> Sample:
    normal = rng.normal(size=3)
    reference = ToolReference(
        p=rng.normal(size=3),
        R=Rotation.random(random_state=rng).as_matrix(),
        v=np.zeros(6),
        a=np.zeros(6),
        normal=normal / np.linalg.norm(normal),
        force=rng.uniform(5.0, 15.0),
    )
    return Sample(random_arm(rng, t, **has), reference, rng.normal(size=6), rng.normal(size=6))


def joint_sample(rng: np.random.Generator, t: float, **has: bool) -> Sample:
    state = random_arm(rng, t, **has)
    reference = JointReference(q=state.q, dq=state.dq, ddq=np.zeros(6))
    return Sample(state, reference, rng.normal(size=6), rng.normal(size=6))


def record(path: Path, samples: list[Sample], phases: list[str] | None = None, **metadata: str) -> Path:
    with Recorder(path, joint_names=NAMES, metadata=metadata) as recorder:
        for i, sample in enumerate(samples):
            recorder.record(sample, "pass" if phases is None else phases[i])
        recorder.end_with(outcome="done")
    assert recorder.error is None
    return path
