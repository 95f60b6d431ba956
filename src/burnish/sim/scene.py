"""The arm in MuJoCo: the one description plus the tool, with the gears of a drawn plant."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from burnish.core import Array
from burnish.model.model import JACO2_URDF
from burnish.model.tool import PolishingTool
from burnish.rotation import exp, quaternion
from burnish.sim.hand import Hand
from burnish.sim.plant import Plant
from burnish.sim.things import Thing
from burnish.surface import DistanceGrid

logger = logging.getLogger(__name__)
# The engine would write MUJOCO_LOG.TXT into the user's folder.
mujoco.set_mju_user_warning(logger.warning)

TIMESTEP = 0.5e-3
"""Physics step [s]: a 50 g tip between its spring and the felt rings at 240 Hz, eight steps a period."""

GRAVITY = np.array([0.0, 0.0, -9.81])
"""Gravity in the base frame [m/s²]."""
BASE, HAND = "link_base", "end_effector"


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A compiled MuJoCo model and the addresses that the robot reads."""

    model: Any
    """mujoco.MjModel."""
    n: int
    """Number of arm joints; the slide of a tool's tip, fingers and loose things come after them."""
    base: int
    """Body of the arm's base."""
    hand: int
    """Body of the tool frame."""
    tip: int
    """Body of the felt tip; its frame's origin is the tip's centre. The hand where there is no tool."""
    tool: int
    """Body of the tool; its frame is the wrist sensor's. The hand where there is no tool."""
    effort_limit: Array
    """Largest joint torques of the description [N·m], (n,)."""


@dataclass(frozen=True, kw_only=True)
class Workpiece:
    """A mould in the simulated cell: its surface, and where the controller is **told** that it stands."""

    grid: DistanceGrid
    p: Array
    """Origin of the mould's frame in the base frame [m], (3,)."""
    R: Array
    """Rotation, base ← mould, (3, 3)."""


def build(
    tool: PolishingTool | None,
    plant: Plant,
    workpiece: Workpiece | None,
    hand: Hand | None = None,
    things: Sequence[Thing] = (),
) -> Scene:
    """Compile the arm of a plant, with a tool, a hand that moves, or neither; the engine's self-healing is off.

    The frame of MuJoCo's world is the frame of the mould, where it really stands: the arm's base is placed in it
    and gravity turned, so that the contact needs no change of axes. Without a mould it is the arm's base frame.
    The engine's own contact is for a hand and the things around it; without a hand it is off.
    """
    spec = mujoco.MjSpec.from_file(str(JACO2_URDF))
    joints = list(spec.joints)
    n = len(joints)
    frame = spec.body(HAND)
    if plant.payload > 0.0:
        # A point mass; the engine wants some extent, and a millimetre is none.
        load = frame.add_body(name="payload")
        _inertial(load, plant.payload, (0.0, 0.0, 0.0), np.full(3, 1e-6 * plant.payload))
    if tool is not None:
        _mount(tool, spec, frame)
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # MuJoCo's joint limits are soft springs; the arm's own limits are the controller's business.
    for joint in joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    fingers = _gripping(hand, things, spec) if hand is not None else []
    if hand is None:
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    if workpiece is not None:
        R = exp(plant.mould_turn) @ workpiece.R
        base = spec.body(BASE)
        base.pos = (-R.T @ (workpiece.p + plant.mould_shift)).tolist()
        base.quat = quaternion(R.T).tolist()
        spec.option.gravity = (R.T @ GRAVITY).tolist()
    model = spec.compile()
    effort = model.jnt_actfrcrange[:n, 1].copy()
    model.dof_armature[:n] = plant.armature
    model.dof_damping[:n] = plant.friction.viscous
    model.dof_frictionloss[:n] = plant.friction.coulomb
    moving = [[model.body(joint.parent.name).id] for joint in joints]
    moving[-1] += [model.body(name).id for name in fingers]
    tools = [model.body(name).id for name in ("tool", "tip")] if tool is not None else []
    for ids, scale in zip([*moving, tools], plant.mass_scale, strict=True):
        model.body_mass[ids] *= scale
        model.body_inertia[ids] *= scale
    # External forces act on a body's centre of mass; of the massless hand that is to be its origin.
    model.body_ipos[model.body(HAND).id] = 0.0
    mujoco.mj_setConst(model, mujoco.MjData(model))
    wrist, end = tools if tools else [model.body(HAND).id] * 2
    return Scene(
        model=model,
        n=n,
        base=model.body(BASE).id,
        hand=model.body(HAND).id,
        tip=end,
        tool=wrist,
        effort_limit=effort,
    )


def _gripping(hand: Hand, things: Sequence[Thing], spec: Any) -> list[str]:
    """The hand with its fingers, and the things around it; returns the names of the fingers' bodies."""
    for thing in things:
        thing.put(spec)
    # With the flat cone of the engine's default a held thing creeps out of the fingers.
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0
    return hand.mount(spec)


def _mount(tool: PolishingTool, spec: Any, hand: Any) -> None:
    """Body, wrist sensor and sprung tip of a tool on the hand."""
    body = hand.add_body(name="tool")
    _inertial(body, tool.body_mass, (0.0, 0.0, tool.body_com), tool.body_inertia)
    body.add_site(name="wrist")
    tip = body.add_body(name="tip", pos=[0.0, 0.0, tool.tip_centre])
    _inertial(tip, tool.tip_mass, (0.0, 0.0, 0.0), tool.tip_inertia)
    tip.add_joint(
        name="tip",
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[0.0, 0.0, 1.0],
        stiffness=tool.stiffness,
        damping=tool.damping,
    )
    wrist = mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="force", type=mujoco.mjtSensor.mjSENS_FORCE, objtype=wrist, objname="wrist")
    spec.add_sensor(name="torque", type=mujoco.mjtSensor.mjSENS_TORQUE, objtype=wrist, objname="wrist")


def _inertial(body: Any, mass: float, com: tuple[float, float, float], inertia: np.ndarray[Any, Any]) -> None:
    """Give a spec's body its mass [kg], centre of mass [m] and principal inertia [kg·m²]."""
    body.explicitinertial = True
    body.mass = mass
    body.ipos = list(com)
    body.inertia = inertia.tolist()
