"""From a description, or numbers, to Pinocchio: one coordinate a joint, and nothing in the file overlooked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from burnish.errors import DescriptionError, InputError
from burnish.model.description_mjcf_rest import rest_of_mjcf
from burnish.model.description_xml import TRIANGLE_TOLERANCE, quoted, read


def engine_of_urdf(path: str | Path) -> pin.Model:
    """The engine's model of a URDF that `check_description` has passed.

    Raises:
        DescriptionError: if it is an MJCF, or if the engine refuses it.
    """
    _expect(path, "robot", "Model.from_mjcf")
    return _with_plain_angles(_read(pin.buildModelFromUrdf, path))


def engine_of_mjcf(path: str | Path) -> pin.Model:
    """The engine's model of an MJCF that `check_description` has passed, with what its reader leaves out.

    Raises:
        DescriptionError: if it is a URDF, or if the engine refuses it.
    """
    _expect(path, "mujoco", "Model.from_urdf")
    rest = rest_of_mjcf(path)
    engine = _with_plain_angles(_read(pin.buildModelFromMJCF, path))
    engine.gravity = pin.Motion(rest.gravity, np.zeros(3))
    engine.lowerPositionLimit = np.where(rest.unlimited, -np.inf, engine.lowerPositionLimit)
    engine.upperPositionLimit = np.where(rest.unlimited, np.inf, engine.upperPositionLimit)
    if not rest.base_moves:
        _place_base(engine, placed(rest.p, rest.R))
    return engine


def rigid_body(mass: float, com: ArrayLike, inertia: ArrayLike) -> pin.Inertia:
    """A body for the engine: mass [kg], centre of mass [m], (3,), and inertia about it [kg·m²], (3, 3).

    The inertia may be that of a point or a rod, which no link may have.

    Raises:
        InputError: if no body can be like that.
    """
    if not np.isfinite(mass) or mass <= 0.0:
        raise InputError(f"payload mass {mass} kg must be finite and more than 0")
    centre, tensor = np.asarray(com, dtype=float), np.asarray(inertia, dtype=float)
    if centre.shape != (3,) or not np.isfinite(centre).all():
        raise InputError(f"payload centre of mass {centre.tolist()}; expected three finite numbers [m]")
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all() or not np.allclose(tensor, tensor.T, atol=0.0):
        raise InputError(f"payload inertia {tensor.tolist()}; expected a finite symmetric (3, 3) matrix [kg·m²]")
    a, b, c = np.linalg.eigvalsh(tensor)
    if a < -TRIANGLE_TOLERANCE * c or c > a + b + TRIANGLE_TOLERANCE * c:
        raise InputError(
            f"payload inertia with principal moments {a:.4g}, {b:.4g}, {c:.4g} kg·m²; expected none below 0 and the "
            "largest at most the sum of the others: check the axes and the point that it was given about"
        )
    return pin.Inertia(float(mass), centre, tensor)


def placed(p: ArrayLike, R: ArrayLike) -> pin.SE3:
    """A placement for the engine: position [m], (3,), and rotation, (3, 3).

    Raises:
        InputError: if they are none.
    """
    point, rotation = np.asarray(p, dtype=float), np.asarray(R, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise InputError(f"position {point.tolist()}; expected three finite numbers [m]")
    if rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=1e-6):
        raise InputError(f"rotation {rotation.tolist()}; expected an orthonormal (3, 3) matrix")
    if np.linalg.det(rotation) < 0.0:
        raise InputError(f"rotation {rotation.tolist()} is a reflection; expected a right-handed matrix")
    return pin.SE3(rotation, point)


def _expect(path: str | Path, tag: str, other: str) -> None:
    """Refuse a file of the other format."""
    found = read(path).tag
    if found != tag:
        raise DescriptionError(f"{path}: found the root element <{found}>; expected <{tag}>: use {other}")


def _read(reader: Callable[[str], pin.Model], path: str | Path) -> pin.Model:
    """A description through the engine's reader, its complaints as ours."""
    try:
        return reader(str(path))
    except (ValueError, RuntimeError) as error:
        raise DescriptionError(f"{path} cannot be read: {quoted(str(error).splitlines()[0])}") from error


def _with_plain_angles(engine: pin.Model) -> pin.Model:
    """The same arm with one coordinate a joint: the engine gives a continuous joint two, (cos, sin).

    Raises:
        DescriptionError: if a joint is not revolute, continuous or prismatic, or the arm branches.
    """
    plain = pin.Model()
    plain.name = engine.name
    plain.gravity = engine.gravity
    for index in range(1, engine.njoints):
        joint = engine.joints[index]
        if joint.nv != 1:
            raise DescriptionError(
                f"joint '{engine.names[index]}' of {engine.name} is a {joint.shortname()}; "
                "expected revolute, continuous or prismatic joints on a fixed base"
            )
        if engine.parents[index] != index - 1:
            raise DescriptionError(
                f"{engine.name} branches at joint '{engine.names[index]}'; expected one serial chain. "
                "Fix the joints that do not belong to the arm (fingers) in the description"
            )
        v = joint.idx_v
        continuous = joint.nq == 2
        plain.addJoint(
            engine.parents[index],
            _plain_joint(joint) if continuous else joint,
            engine.jointPlacements[index],
            engine.names[index],
            engine.effortLimit[v : v + 1],
            engine.velocityLimit[v : v + 1],
            np.array([-np.inf]) if continuous else engine.lowerPositionLimit[joint.idx_q : joint.idx_q + 1],
            np.array([np.inf]) if continuous else engine.upperPositionLimit[joint.idx_q : joint.idx_q + 1],
        )
        plain.appendBodyToJoint(index, engine.inertias[index], pin.SE3.Identity())
    for frame in list(engine.frames)[1:]:
        plain.addFrame(pin.Frame(frame.name, frame.parentJoint, 0, frame.placement, frame.type), False)
    plain.armature = engine.armature
    return plain


def _plain_joint(joint: pin.JointModel) -> pin.JointModel:
    """The revolute joint with one coordinate about the axis of an unbounded one."""
    kinds = {"JointModelRUBX": pin.JointModelRX, "JointModelRUBY": pin.JointModelRY, "JointModelRUBZ": pin.JointModelRZ}
    if joint.shortname() in kinds:
        return kinds[joint.shortname()]()
    return pin.JointModelRevoluteUnaligned(joint.extract().axis)


def _place_base(engine: pin.Model, base: pin.SE3) -> None:
    """Put the arm, whose base body the engine believes to stand in the world's origin, where it stands."""
    engine.jointPlacements[1] = base * engine.jointPlacements[1]
    for frame in list(engine.frames)[1:]:
        if frame.parentJoint == 0:
            frame.placement = base * frame.placement
