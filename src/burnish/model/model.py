"""`Model`: an arm evaluated at a state, on Pinocchio."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from importlib.resources import files
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from burnish.core import Array, Dynamics, State, read_only
from burnish.errors import DescriptionError, InputError
from burnish.model.description import check_description
from burnish.model.engine import engine_of_mjcf, engine_of_urdf, placed, rigid_body
from burnish.model.friction import Friction

JACO2_URDF = Path(str(files("burnish") / "assets" / "jaco2.urdf"))


class Model:
    """A fixed-base serial arm: its description, evaluated once a cycle into a `Dynamics`.

    A model owns one work space of the engine, so use one model in one thread. ``with_…`` return a new model and
    leave this one alone. Limits of continuous joints are absent: ±inf in `lower` and `upper`.
    """

    def __init__(self, engine: pin.Model, tool: str, friction: Friction | None = None) -> None:
        """Wrap an engine's model; use `jaco2`, `from_urdf` or `from_mjcf` instead."""
        if not engine.existFrame(tool):
            frames = ", ".join(frame.name for frame in engine.frames if frame.name != "universe")
            raise DescriptionError(f"tool frame '{tool}' does not exist in {engine.name}; it has: {frames}")
        self._engine = engine
        self._data = data = engine.createData()
        self._tool = engine.getFrameId(tool)
        # Views into the engine's work space, made once: to look one up costs more than to copy it.
        self._M, self._bias, self._g = data.M, data.nle, data.g
        self._p, self._R = data.oMf[self._tool].translation, data.oMf[self._tool].rotation
        self.n: int = engine.nv
        self.name: str = engine.name
        self.tool: str = tool
        self.joint_names: tuple[str, ...] = tuple(engine.names)[1:]
        self.lower: Array = read_only(engine.lowerPositionLimit)
        """Lower joint limits [rad], slides [m], (n,); −inf for a continuous joint."""
        self.upper: Array = read_only(engine.upperPositionLimit)
        """Upper joint limits [rad], slides [m], (n,); +inf for a continuous joint."""
        kinds = [joint.shortname() for joint in engine.joints[1:]]
        self.prismatic: NDArray[np.bool_] = np.array([kind.startswith("JointModelP") for kind in kinds])
        """Whether each joint slides, (n,): its coordinate and its limits are in metres, its torque is a force [N]."""
        self.velocity_limit: Array = read_only(engine.velocityLimit)
        """Largest joint speeds [rad/s], slides [m/s], (n,); +inf where the file gives none, as an MJCF does."""
        self.effort_limit: Array = read_only(engine.effortLimit)
        """Largest joint torques [N·m], slides [N], (n,); +inf where the file gives none."""
        self.armature: Array = read_only(engine.armature)
        """Rotor inertia reflected through the gears [kg·m²], (n,) (a slide: [kg]); part of M. Zero unless an MJCF
        gives it or `with_armature` does."""
        self.friction: Friction | None = friction
        """Friction of the joints, for the laws that compensate it; None unless `with_friction` gave one. No term of
        `Dynamics` contains it."""

    def __reduce__(self) -> tuple[type[Model], tuple[pin.Model, str, Friction | None]]:
        """A copy, or one in another process, gets a work space of its own."""
        return Model, (self._engine, self.tool, self.friction)

    @classmethod
    def jaco2(cls) -> Model:
        """The Kinova JACO2 with its KG-3 hand, links only, tool frame ``end_effector`` between the finger tips."""
        return cls.from_urdf(JACO2_URDF, tool="end_effector")

    @classmethod
    def from_urdf(cls, path: str | Path, tool: str) -> Model:
        """Read a fixed-base serial arm from a URDF file.

        Args:
            path: the file.
            tool: name of the link that is the tool.

        Raises:
            DescriptionError: if the file is missing, is not a URDF, describes what no arm can be, or has no such tool.
        """
        check_description(Path(path), tool)
        return cls(engine_of_urdf(path), tool)

    @classmethod
    def from_mjcf(cls, path: str | Path, tool: str) -> Model:
        """Read a fixed-base serial arm from a MuJoCo XML file; ``tool`` is a body or a site of it.

        Gravity, the place of the base and armature count as the file gives them; friction, springs and actuators do
        not.

        Raises:
            DescriptionError: as `from_urdf`.
        """
        check_description(Path(path), tool)
        return cls(engine_of_mjcf(path), tool)

    def with_armature(self, armature: ArrayLike) -> Model:
        """A model whose M contains this reflected rotor inertia, (n,) or one number for all [kg·m²], a slide's [kg].

        It takes the place of the armature that the model had.

        Raises:
            InputError: if a number is negative or not finite, or if there is none for each joint.
        """
        values = np.asarray(armature, dtype=float)
        if values.shape not in ((), (self.n,)) or not np.all(np.isfinite(values)) or np.any(values < 0.0):
            raise InputError(f"armature {values} must be one number or {self.n}, finite and at least 0 kg·m²")
        engine = pin.Model(self._engine)
        engine.armature = np.array(np.broadcast_to(values, (self.n,)))
        return Model(engine, self.tool, self.friction)

    def with_friction(self, friction: Friction) -> Model:
        """A model that carries this friction in `friction`; M, h and g stay as they are.

        Raises:
            InputError: if it is the friction of another number of joints.
        """
        if len(friction.coulomb) != self.n:
            raise InputError(f"the friction is of {len(friction.coulomb)} joints; {self.name} has {self.n}")
        return Model(self._engine, self.tool, friction)

    def with_payload(self, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia: ArrayLike | None = None) -> Model:
        """A model that carries a body fixed to the tool frame, besides those that it carries already.

        Args:
            mass: mass of the body [kg], more than 0.
            com: its centre of mass in the tool frame [m], (3,).
            inertia: its inertia about that centre, tool axes [kg·m²], (3, 3); a point mass without it.

        Raises:
            InputError: if no body can be like that.
        """
        body = rigid_body(mass, com, np.zeros((3, 3)) if inertia is None else inertia)
        engine = pin.Model(self._engine)
        frame = engine.frames[self._tool]
        engine.appendBodyToJoint(frame.parentJoint, body, frame.placement)
        return Model(engine, self.tool, self.friction)

    def with_tool(self, name: str, p: ArrayLike, R: ArrayLike | None = None) -> Model:
        """A model whose tool frame is a new one, placed at (p [m], R) in today's tool frame; it has no weight.

        Raises:
            InputError: if the model has a frame of that name, p is no point, or R is no rotation.
        """
        engine = pin.Model(self._engine)
        if engine.existFrame(name):
            raise InputError(f"{self.name} has a frame '{name}' already; expected a new name for the tool frame")
        frame = engine.frames[self._tool]
        placement = frame.placement * placed(p, np.eye(3) if R is None else R)
        engine.addFrame(pin.Frame(name, frame.parentJoint, self._tool, placement, pin.FrameType.OP_FRAME))
        return Model(engine, name, self.friction)

    def limit_distance(self, q: ArrayLike) -> Array:
        """How far each joint is from the nearer of its limits, min(q − lower, upper − q), (n,) [rad], a slide's [m].

        +inf for a continuous joint, negative for a joint beyond a limit.
        """
        joints = np.asarray(q, dtype=float)
        return np.asarray(np.minimum(joints - self.lower, self.upper - joints))

    def at(self, state: State) -> Dynamics:
        """Evaluate all terms at a state.

        Raises:
            InputError: if the state has another number of joints.
        """
        if state.q.shape != (self.n,):
            raise InputError(f"the state has {len(state.q)} joints, {self.name} has {self.n}")
        engine, data = self._engine, self._data
        pin.computeAllTerms(engine, data, state.q, state.dq)
        pin.updateFramePlacement(engine, data, self._tool)
        # One joint alone gives a vector.
        J = pin.getFrameJacobian(engine, data, self._tool, pin.LOCAL_WORLD_ALIGNED).reshape(6, self.n)
        dJdq = pin.getFrameClassicalAcceleration(engine, data, self._tool, pin.LOCAL_WORLD_ALIGNED)
        g = self._g.copy()
        return Dynamics.of(
            t=state.t,
            q=state.q,
            dq=state.dq,
            p=self._p.copy(),
            R=self._R.copy(),
            J=J,
            dJdq=dJdq.vector.copy(),
            M=self._M.copy(),
            h=self._bias - g,
            g=g,
            tau=state.tau,
            F=None,
        )

    def kinematics(self, q: Array) -> tuple[Array, Array, Array]:
        """Tool position [m], rotation and Jacobian at ``q``, as in `Dynamics`, without the dynamics."""
        engine, data = self._engine, self._data
        J = pin.computeFrameJacobian(engine, data, q, self._tool, pin.LOCAL_WORLD_ALIGNED)
        return self._p.copy(), self._R.copy(), J.reshape(6, self.n)

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every frame of the description, base ← frame, as name → (4, 4) homogeneous matrix."""
        pin.framesForwardKinematics(self._engine, self._data, np.asarray(q, dtype=float))
        return {
            frame.name: np.array(placement.homogeneous)
            for frame, placement in zip(self._engine.frames, self._data.oMf, strict=True)
        }


def urdf_estimates(path: str | Path = JACO2_URDF) -> tuple[Array, Friction]:
    """Estimated armature [kg·m²], (n,), and friction of a description that carries ``estimate`` elements."""
    joints = [j for j in ElementTree.parse(path).getroot().iter("joint") if j.find("estimate") is not None]
    values = {
        key: np.array([float(joint.find("estimate").get(key, "nan")) for joint in joints])  # type: ignore[union-attr]
        for key in ("armature", "coulomb", "viscous")
    }
    return values["armature"], Friction(coulomb=values["coulomb"], viscous=values["viscous"])
