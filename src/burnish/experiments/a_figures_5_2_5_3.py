"""Thesis A, figures 5.2 and 5.3: orientation in the null space of the position, by both inverses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from burnish.control import DynamicNullSpace, GeometricNullSpace, JacobianTranspose
from burnish.experiments.thesis_a import (
    OURS_HONEST,
    OURS_IDEAL,
    TABLE_5_2,
    UNREACHABLE,
    as_printed,
    judge_pose,
    pose_trials,
    start_joints,
)
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.trials.experiment import Experiment, Finding, Trial, links_only
from burnish.trials.record import Record, rms

GEOMETRIC, DYNAMIC = "W = I: ", "W = M: "
TRANSPOSE = "Jacobian transpose: printed, honest"


def trials() -> Sequence[Trial]:
    """Both laws as the thesis had them and with our gains, and the law of its figure 5.1 to compare with."""
    geometric = pose_trials(lambda: GeometricNullSpace(**TABLE_5_2), ours_geometric, GEOMETRIC)
    dynamic = pose_trials(lambda: DynamicNullSpace(**TABLE_5_2), ours_dynamic, DYNAMIC)
    transpose = Trial(
        name=TRANSPOSE,
        law=JacobianTranspose(**TABLE_5_2),
        source=as_printed(),
        duration=geometric[0].duration,
        arm=arms.honest(0),
        model=links_only(),
        q=start_joints(),
        rate=100.0,
    )
    return [*geometric, *dynamic, transpose]


def ours_geometric(arm: Arm) -> GeometricNullSpace:
    """With the gains of the Jacobian transpose."""
    return GeometricNullSpace(**(OURS_IDEAL if arm.friction is None else OURS_HONEST))


def ours_dynamic(arm: Arm) -> DynamicNullSpace:
    """With the same gains."""
    return DynamicNullSpace(**(OURS_IDEAL if arm.friction is None else OURS_HONEST))


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """What the thesis says of both figures."""
    position = {
        name: 1e3 * rms(records[name].position_error)
        for name in (TRANSPOSE, GEOMETRIC + "printed, honest", DYNAMIC + "printed, honest")
    }
    transpose, geometric, dynamic = position.values()
    return [
        Finding(
            claim="The thesis: in the geometric null space of the position the orientation disturbs it less.",
            measured=f"Honest arm, printed, position RMSE: {geometric:.1f} mm (W = I), {dynamic:.1f} mm (W = M), "
            f"{transpose:.1f} mm without a null space.",
            holds=geometric < transpose,
        ),
        Finding(
            claim="The thesis: the dynamically consistent inverse is no better than the geometric one, for want of a "
            "good M. The links alone are no good M.",
            measured=f"{dynamic:.1f} mm{_stopped(records[DYNAMIC + 'printed, honest'])} against {geometric:.1f} mm "
            f"with the links in M; with the nominal rotors, and our gains, {_mm(records, DYNAMIC):.2f} mm against "
            f"{_mm(records, GEOMETRIC):.2f} mm.",
            holds=dynamic > 0.9 * geometric and _mm(records, DYNAMIC) < _mm(records, GEOMETRIC),
        ),
        *judge_pose(records, GEOMETRIC),
        *judge_pose(records, DYNAMIC),
    ]


def _mm(records: Mapping[str, Record], prefix: str) -> float:
    """Position RMSE along the printed motion with our gains and rotors in M [mm]."""
    return 1e3 * rms(records[prefix + "printed, honest, ours"].position_error)


def _stopped(record: Record) -> str:
    return "" if record.stopped is None else f" until it was stopped after {record.time[-1]:.1f} s"


EXPERIMENT = Experiment(
    title="Orientation in the null space of the position, geometric and dynamic",
    source="Thesis A, 4.1.3 and 5.3, figures 5.2 (W = I) and 5.3 (W = M), gains of table 5.2",
    about=f"""The position takes precedence; what turns the tool is filtered so that it exerts no force on its point
    (W = I) or does not accelerate it (W = M). The thesis found the position better than with the Jacobian transpose,
    and the dynamic inverse no better than the geometric one, which it put down to its model. {UNREACHABLE}""",
    trials=trials,
    judge=judge,
)
