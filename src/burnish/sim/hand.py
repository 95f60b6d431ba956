"""The KG-3 hand in MuJoCo: three fingers that move and grip, in place of the open ones of the description.

Each finger is driven through a screw that nothing pushes back: its nut runs towards the wanted angle, and stands still
where the finger takes more than the drive's torque. Finger and nut are joined by a spring, the bending of the finger:

    τ = k (θ − q) − d q̇,      |θ̇| ≤ speed,      the nut only runs on while |k (θ − q)| ≤ torque

So the two fingers press with what their drives give, and the thumb, which they push back, bears the sum. The tips hang
on springs and are held straight by a stop. Capsules stand for the phalanges; they meet things, not each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from burnish.core import Array
from burnish.errors import InputError
from burnish.model.inertia import Body
from burnish.model.jaco2_parts import FINGERS_CLOSED, finger_frames, jaco2_parts
from burnish.rotation import quaternion
from burnish.sim.things import CONTACT, HAND, SPIN, THING

CLOSED = FINGERS_CLOSED
"""Finger joints when closed [rad]; open is 0."""
STOP, TIP_STOP = 1.51, 2.0
"""Upper ends of the joints of fingers and tips [rad], vendor's description; the lower ones are 0."""
STIFFNESS = 20.0
"""k, of a finger between its nut and its joint [N·m/rad]: a guess; the drive's torque bends it by 3°."""
DAMPING, ARMATURE = 0.2, 1e-3
"""d [N·m·s/rad], and the inertia of the gear behind the joint [kg·m²]: guesses, well damped together with the spring.
DeepMind's model of this hand has 0.75 and 0.1, but its motor is at the joint; ours is behind the screw."""
STALLED, FREE = 0.98, 0.5
"""Shares of its torque at which a drive stalls, and at which it starts again: a screw that stands sticks; a guess."""
DRY = 0.1
"""Dry friction of a finger joint [N·m], as in DeepMind's model."""
TIP_STIFFNESS, TIP_REST, TIP_DAMPING, TIP_ARMATURE = 0.1, -0.5, 5e-3, 1e-4
"""Spring of a tip [N·m/rad], the angle where it would rest but for the stop [rad], damping [N·m·s/rad], and an inertia
that steadies it [kg·m²]; guesses."""
HARD_STOP = [1e-3, 1.0]
"""The engine's stops are springs; these are as stiff as its time step allows. A grip bends a tip by less than 0.5°."""
PHALANGES = (
    ((0.002, -0.008, 0.0), (0.042, -0.008, 0.0), 0.0095),
    ((0.044, -0.007, 0.0), (0.080, -0.009, 0.0), 0.0075),
)
"""Ends and radius of the capsules [m] in the finger's frame, after the vendor's meshes; 88 mm in all."""
TIP_JOINT = np.array([0.044, -0.003, 0.0])
"""Joint of the tip in the finger's frame [m], vendor's description."""
PALM = (-0.052, -0.112, 0.037)
"""The palm as a cylinder: its ends along z of link 6, and its radius [m], as the description draws it."""
DRY_FRICTION = int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)


@dataclass(frozen=True, kw_only=True)
class Hand:
    """What the drives of a KG-3 hand give, and how its pads grip."""

    speed: float = CLOSED / 1.2
    """Of a finger joint [rad/s]: closed in 1.2 s, as the vendor says."""
    torque: float = 0.8
    """Of a drive [N·m]: with it the thumb presses a 50 mm box with about the 25 N that the vendor says."""
    friction: float = 0.8
    """Coulomb friction µ of the pads: a guess for rubber."""

    def __post_init__(self) -> None:
        for name in ("speed", "torque", "friction"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(f"Hand: {name} is {getattr(self, name)}; expected a number above 0")

    def mount(self, spec: Any) -> list[str]:
        """Put it in place of the open hand of an arm's specification; returns the names of the fingers' bodies."""
        link, (palm, *bones) = spec.body("link_6"), jaco2_parts()[6]
        _inertial(link, palm)
        top, bottom, radius = PALM
        cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
        link.add_geom(type=cylinder, fromto=[0, 0, top, 0, 0, bottom], size=[radius, 0, 0], **self._pads())
        bodies = []
        for i, T in enumerate(finger_frames()):
            at, joint = (T[:3, :3] @ TIP_JOINT + T[:3, 3]).tolist(), f"finger_{i + 1}"
            # Both bodies keep the axes and the origin of link 6, in which the parts are described.
            finger = self._phalanx(link, joint, bones[2 * i], T, PHALANGES[0])
            finger.add_joint(
                name=joint,
                pos=T[:3, 3].tolist(),
                axis=T[:3, 2].tolist(),
                range=[0.0, STOP],
                solref_limit=HARD_STOP,
                damping=DAMPING,
                armature=ARMATURE,
                frictionloss=DRY,
            )
            tip = self._phalanx(finger, f"{joint}_tip", bones[2 * i + 1], T, PHALANGES[1])
            tip.add_joint(
                name=f"{joint}_tip",
                pos=at,
                axis=T[:3, 2].tolist(),
                range=[0.0, TIP_STOP],
                solref_limit=HARD_STOP,
                stiffness=TIP_STIFFNESS,
                springref=TIP_REST,
                damping=TIP_DAMPING,
                armature=TIP_ARMATURE,
            )
            _drive(spec, joint)
            bodies += [joint, f"{joint}_tip"]
        return bodies

    def _phalanx(self, parent: Any, name: str, bone: Body, T: Array, capsule: Any) -> Any:
        """A body of the finger with frame T, link 6 ← finger."""
        body = parent.add_body(name=name)
        _inertial(body, bone)
        start, end, radius = capsule
        ends = [T[:3, :3] @ point + T[:3, 3] for point in (start, end)]
        shape = mujoco.mjtGeom.mjGEOM_CAPSULE
        body.add_geom(
            name=name, type=shape, fromto=np.concatenate(ends).tolist(), size=[radius, 0.0, 0.0], **self._pads()
        )
        return body

    def _pads(self) -> dict[str, Any]:
        """How the hand meets things: its friction counts, whatever theirs is."""
        return {
            "contype": HAND,
            "conaffinity": THING,
            "friction": [self.friction, SPIN, 0.0],
            "priority": 1,
            "mass": 0.0,
            **CONTACT,
        }


class Fingers:
    """The drives of a mounted hand: told where to go, once a cycle."""

    def __init__(self, hand: Hand, model: Any, data: Any) -> None:
        """At the state of ``data``, a mujoco.MjData of ``model``."""
        names = [f"finger_{i}" for i in (1, 2, 3)]
        self._hand, self._model, self._data = hand, model, data
        self._joints = [int(model.joint(name).qposadr[0]) for name in names]
        self._owner = dict[int, int]()
        for i, name in enumerate(names):
            self._owner |= {model.geom(name).id: i, model.geom(f"{name}_tip").id: i}
        self._nut, self._speed = data.act, data.ctrl
        self._wanted, self._stalled = np.array(self._nut), np.zeros(3, dtype=np.bool_)

    def angles(self) -> Array:
        """Of the drives, which is where their encoders are [rad], (3,)."""
        return np.array(self._nut)

    def go_to(self, angles: ArrayLike) -> None:
        """From the next cycle on move towards these angles [rad], (3,), within 0 and `CLOSED`.

        Raises:
            InputError: if they are not three finite numbers.
        """
        wanted = np.asarray(angles, dtype=np.float64)
        if wanted.shape != (3,) or not np.isfinite(wanted).all():
            raise InputError(f"fingers: {wanted.tolist()}; expected three angles from 0 (open) to {CLOSED:.3f} rad")
        self._wanted = np.clip(wanted, 0.0, CLOSED)

    def drive(self, seconds: float) -> None:
        """Let the nuts run for the next ``seconds``: no faster, and against no more torque, than the drives can.

        The torque is looked at once a cycle, which below 50 Hz makes the drives slower, never stronger.
        """
        q, nut, step = self._data.qpos[self._joints], self._nut, self._hand.speed * seconds
        share = STIFFNESS * np.abs(nut - q) / self._hand.torque
        self._stalled = (share > STALLED) | self._stalled & (share > FREE)
        bend = np.where(self._stalled, 0.0, self._hand.torque / STIFFNESS)
        # A nut is not pushed back where its finger is, and moves on its own whenever that unloads the finger.
        aim = nut + np.clip(self._wanted - nut, -step, step)
        aim = np.clip(aim, np.minimum(nut, q - bend), np.maximum(nut, q + bend))
        self._speed[:] = (aim - nut) / seconds

    def dry_friction(self, n: int) -> Array:
        """Dry friction of the arm's joints [N·m], (n,): the engine's constraint force without what the contacts add."""
        data, friction = self._data, np.zeros(n)
        rows = np.flatnonzero(data.efc_type == DRY_FRICTION)
        joints = data.efc_id[rows]
        friction[joints[joints < n]] = data.efc_force[rows[joints < n]]
        return friction

    def grip(self) -> Array:
        """Normal force that each finger has on things [N], (3,); the first is the thumb."""
        force, pressed = np.zeros(6), np.zeros(3)
        for i, contact in enumerate(self._data.contact):
            finger = self._owner.get(contact.geom[0], self._owner.get(contact.geom[1]))
            if finger is not None:
                mujoco.mj_contactForce(self._model, self._data, i, force)
                pressed[finger] += force[0]
        return pressed


def _drive(spec: Any, joint: str) -> None:
    """The spring between a joint and its nut, whose speed is the control."""
    actuator = spec.add_actuator(
        name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR
    )
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[0], actuator.biasprm[1] = STIFFNESS, -STIFFNESS


def _inertial(body: Any, part: Body) -> None:
    """Give a spec's body the mass [kg], centre of mass [m] and inertia [kg·m²] of a part in its frame."""
    moments, axes = np.linalg.eigh(part.tensor)
    axes *= np.sign(np.linalg.det(axes))
    body.explicitinertial = True
    body.mass, body.ipos = part.mass, part.com.tolist()
    body.inertia, body.iquat, body.fullinertia = moments.tolist(), quaternion(axes).tolist(), [np.nan] * 6
