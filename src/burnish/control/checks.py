"""What a law asks of its reference and of the arm, and how it refuses what it cannot use."""

from __future__ import annotations

from burnish.core import Array, Dynamics, JointReference, ToolReference
from burnish.errors import InputError


def need_tool_reference(law: object, reference: object) -> None:
    """Refuse what is no `ToolReference`, by an error that names both.

    Raises:
        InputError: then.
    """
    if not isinstance(reference, ToolReference):
        raise InputError(
            f"{type(law).__name__} follows the tool and was given a {type(reference).__name__}; "
            "give it a ToolReference (from HoldPose, CubicPose), or take a joint-space law"
        )


def need_joint_reference(law: object, reference: object) -> None:
    """Refuse what is no `JointReference`, by an error that names both.

    Raises:
        InputError: then.
    """
    if not isinstance(reference, JointReference):
        raise InputError(
            f"{type(law).__name__} follows the joints and was given a {type(reference).__name__}; "
            "give it a JointReference (from Hold, Cubic, Sine), or take a task-space law"
        )


def measured_wrench(law: object, arm: Dynamics) -> Array:
    """F of the arm [N, N·m], (6,).

    Raises:
        InputError: if nothing has estimated it.
    """
    if arm.F is None:
        raise InputError(f"{type(law).__name__} needs a contact wrench; give the rig a WristSense or a JointSense")
    return arm.F


def need_inverse_of_jacobian(law: object, arm: Dynamics, instead: str) -> None:
    """Refuse an arm whose J is not square, and name the law to take ``instead``.

    Raises:
        InputError: then.
    """
    if len(arm.q) != 6:
        raise InputError(
            f"{type(law).__name__} inverts J and needs an arm of 6 joints; this one has {len(arm.q)}. Take {instead}"
        )
