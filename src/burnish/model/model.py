"""`Model`: an arm evaluated at a state, on Pinocchio; the only file that knows that engine."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from burnish.core import Array, Dynamics, State, read_only
from burnish.errors import DescriptionError, InputError
from burnish.model.description import check_description
from burnish.model.friction import Friction

JACO2_URDF = Path(str(files("burnish") / "assets" / "jaco2.urdf"))


class Model:
    """A fixed-base serial arm: its description, evaluated once a cycle into a `Dynamics`.

    A model owns one work space of the engine, so use one model in one thread. ``with_…`` return a new model and
    leave this one alone. Limits of continuous joints are absent: ±inf in `lower` and `upper`.
    """

    def __init__(self, engine: pin.Model, tool: str) -> None:
        """Wrap an engine's model; use `jaco2`, `from_urdf` or `from_mjcf` instead."""
        if not engine.existFrame(tool):
            frames = ", ".join(frame.name for frame in engine.frames if frame.name != "universe")
            raise DescriptionError(f"tool frame '{tool}' does not exist in {engine.name}; it has: {frames}")
        self._engine = engine
        self._data = engine.createData()
        self._tool = engine.getFrameId(tool)
        self.n: int = engine.nv
        self._below = np.tril_indices(self.n, -1)
        self.name: str = engine.name
        self.tool: str = tool
        self.joint_names: tuple[str, ...] = tuple(engine.names)[1:]
        self.lower: Array = read_only(engine.lowerPositionLimit)
        """Lower joint limits [rad], (n,); −inf for a continuous joint."""
        self.upper: Array = read_only(engine.upperPositionLimit)
        """Upper joint limits [rad], (n,); +inf for a continuous joint."""
        self.velocity_limit: Array = read_only(engine.velocityLimit)
        """Largest joint speeds [rad/s], (n,)."""
        self.effort_limit: Array = read_only(engine.effortLimit)
        """Largest joint torques [N·m], (n,)."""
        self.armature: Array = read_only(engine.armature)
        """Rotor inertia reflected through the gears [kg·m²], (n,); part of M. Zero unless asked for."""

    @classmethod
    def jaco2(cls) -> Model:
        """The Kinova JACO2 with its KG-3 hand, links only, tool frame ``end_effector`` between the finger tips."""
        return cls.from_urdf(JACO2_URDF, tool="end_effector")

    @classmethod
    def from_urdf(cls, path: str | Path, tool: str) -> Model:
        """Read a fixed-base serial arm from a URDF file.

        Args:
            path: the file.
            tool: name of the link or frame that is the tool.

        Raises:
            DescriptionError: if the file is missing, is not a URDF, describes what no arm can be, or has no such tool.
        """
        check_description(Path(path), tool)
        return cls(_with_plain_angles(_read(pin.buildModelFromUrdf, path)), tool)

    @classmethod
    def from_mjcf(cls, path: str | Path, tool: str) -> Model:
        """Read a fixed-base serial arm from a MuJoCo XML file; ``tool`` is a body or a site of it.

        Raises:
            DescriptionError: as `from_urdf`.
        """
        check_description(Path(path), tool)
        return cls(_with_plain_angles(_read(pin.buildModelFromMJCF, path)), tool)

    def with_armature(self, armature: ArrayLike) -> Model:
        """A model whose M contains this reflected rotor inertia, (n,) or one number for all [kg·m²]."""
        values = np.broadcast_to(np.asarray(armature, dtype=float), (self.n,))
        if not np.all(np.isfinite(values)) or np.any(values < 0.0):
            raise InputError(f"armature {values} must be finite and at least 0 kg·m²")
        engine = pin.Model(self._engine)
        engine.armature = np.array(values)
        return Model(engine, self.tool)

    def with_payload(self, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia: ArrayLike | None = None) -> Model:
        """A model that carries a body fixed to the tool frame.

        Args:
            mass: mass of the body [kg], more than 0.
            com: its centre of mass in the tool frame [m], (3,).
            inertia: its inertia about that centre, tool axes [kg·m²], (3, 3); a point mass without it.
        """
        if not np.isfinite(mass) or mass <= 0.0:
            raise InputError(f"payload mass {mass} kg must be finite and more than 0")
        tensor = np.zeros((3, 3)) if inertia is None else np.asarray(inertia, dtype=float)
        body = pin.Inertia(float(mass), np.asarray(com, dtype=float), tensor)
        engine = pin.Model(self._engine)
        frame = engine.frames[self._tool]
        engine.appendBodyToJoint(frame.parentJoint, body, frame.placement)
        return Model(engine, self.tool)

    def with_tool(self, name: str, p: ArrayLike, R: ArrayLike | None = None) -> Model:
        """A model whose tool frame is a new one, placed at (p [m], R) in today's tool frame."""
        rotation = np.eye(3) if R is None else np.asarray(R, dtype=float)
        engine = pin.Model(self._engine)
        frame = engine.frames[self._tool]
        placement = frame.placement * pin.SE3(rotation, np.asarray(p, dtype=float))
        engine.addFrame(pin.Frame(name, frame.parentJoint, self._tool, placement, pin.FrameType.OP_FRAME))
        return Model(engine, name)

    def at(self, state: State) -> Dynamics:
        """Evaluate all terms at a state.

        Raises:
            InputError: if the state has another number of joints.
        """
        if state.q.shape != (self.n,):
            raise InputError(f"the state has {len(state.q)} joints, {self.name} has {self.n}")
        engine, data = self._engine, self._data
        pin.computeAllTerms(engine, data, state.q, state.dq)
        tool = pin.updateFramePlacement(engine, data, self._tool)
        # One joint alone gives a vector.
        J = pin.getFrameJacobian(engine, data, self._tool, pin.LOCAL_WORLD_ALIGNED).reshape(6, self.n)
        dJdq = pin.getFrameClassicalAcceleration(engine, data, self._tool, pin.LOCAL_WORLD_ALIGNED)
        # The engine fills the upper triangle only.
        M = data.M.copy()
        M[self._below] = M.T[self._below]
        g = data.g.copy()
        return Dynamics(
            t=state.t,
            q=state.q,
            dq=state.dq,
            p=tool.translation.copy(),
            R=tool.rotation.copy(),
            J=J,
            dJdq=dJdq.vector.copy(),
            M=M,
            h=data.nle - g,
            g=g,
            tau=state.tau,
        )

    def kinematics(self, q: Array) -> tuple[Array, Array, Array]:
        """Tool position [m], rotation and Jacobian at ``q``, as in `Dynamics`, without the dynamics."""
        engine, data = self._engine, self._data
        J = pin.computeFrameJacobian(engine, data, q, self._tool, pin.LOCAL_WORLD_ALIGNED)
        tool = data.oMf[self._tool]
        return tool.translation.copy(), tool.rotation.copy(), J

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every frame of the description, base ← frame, as name → (4, 4) homogeneous matrix."""
        pin.framesForwardKinematics(self._engine, self._data, np.asarray(q, dtype=float))
        return {
            frame.name: np.array(placement.homogeneous)
            for frame, placement in zip(self._engine.frames, self._data.oMf, strict=True)
        }


def _read(reader: Callable[[str], pin.Model], path: str | Path) -> pin.Model:
    """A description through the engine's reader, its complaints as ours."""
    try:
        return reader(str(path))
    except (ValueError, RuntimeError) as error:
        raise DescriptionError(f"{path} cannot be read: {str(error).splitlines()[0]}") from error


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
    return plain


def _plain_joint(joint: pin.JointModel) -> pin.JointModel:
    """The revolute joint with one coordinate about the axis of an unbounded one."""
    kinds = {"JointModelRUBX": pin.JointModelRX, "JointModelRUBY": pin.JointModelRY, "JointModelRUBZ": pin.JointModelRZ}
    if joint.shortname() in kinds:
        return kinds[joint.shortname()]()
    return pin.JointModelRevoluteUnaligned(joint.extract().axis)


def urdf_estimates(path: str | Path = JACO2_URDF) -> tuple[Array, Friction]:
    """Estimated armature [kg·m²], (n,), and friction of a description that carries ``estimate`` elements."""
    joints = [j for j in ElementTree.parse(path).getroot().iter("joint") if j.find("estimate") is not None]
    values = {
        key: np.array([float(joint.find("estimate").get(key, "nan")) for joint in joints])  # type: ignore[union-attr]
        for key in ("armature", "coulomb", "viscous")
    }
    return values["armature"], Friction(coulomb=values["coulomb"], viscous=values["viscous"])
