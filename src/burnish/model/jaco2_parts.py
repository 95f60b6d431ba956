"""The JACO2's links as they are used, and the shells, actuators, rings and fingers that they are made of.

All bodies are described in the frame of their link (z on the link's own joint, as in the vendor's description).
Link i carries shell i, actuator i + 1 and the plastic ring over that actuator; the hand has palm and fingers.

What is known: the masses of all parts (thesis A, tables 3.5–3.7; shell of the base: abr_jaco2), the actuators' size
(data sheet), palm and fingers (vendor's CAD and meshes). What is not: the shells' centres of mass and inertia, which
stood in thesis A's missing appendix B. The shells here are **what the links leave** when actuator and ring are taken
away: a decomposition of `jaco2_links`, not an independent check of it. Shells 0, 1, 2, 4 and 5 come out physical.
Shell 3 does not: its principal moments would be (75, 660, 796)·1e-6 kg·m², and 796 > 75 + 660, because the link's
centre of mass (CAD) and its inertia (computed over a mesh) have two origins that do not quite agree. It is replaced by
the nearest physical shell, which moves link 3 by 0.64 mm and 0.34 % (0.66 % of I_yz); both are far inside their doubt.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from burnish.core import Array
from burnish.model.inertia import Body, combine, hoop, solid_cylinder

LARGE, SMALL = (0.0745, 0.060), (0.058, 0.055)
"""Diameter and length of the actuators K-75+ (joints 1–3) and K-58 (joints 4–6) [m]; data sheet. Solid and uniform, and
centred on its joint: both are assumptions."""
FINGERS_CLOSED = float(np.deg2rad(80.0))
"""Finger joints when closed [rad]: 6800 of the vendor's units; open is 0."""


def jaco2_links() -> tuple[Body, ...]:
    """Base and links 1 … 6 of the JACO2 as the models use them, each in its link frame; 6 is the hand, fingers open.

    Mass: thesis A, tables 3.5–3.7, doubt 2 % (hand 10 %). Centre of mass: abr_control's CAD values, doubt 8 mm (hand
    12 mm). Inertia: computed, uniform shells over the vendor's meshes and solid actuators, doubt 10 % (hand 30 %).
    """
    return (
        _body("base", 1.22568, (0.0, 0.0, 0.1255), (4543.61, 4547.35, 1268.62, 0.0, 0.0, 1.28)),
        _body("link 1", 0.753704, (4.2e-5, -0.001285, -0.112784), (1300.28, 1334.67, 600.07, 0.0, 0.0, 15.24)),
        _body("link 2", 1.009334, (-1.4e-5, -0.329006, -0.009353), (20503.5, 832.0, 20568.98, 0.0, 0.0, 1098.05)),
        _body("link 3", 0.559414, (3.9e-5, 0.153270, -0.018069), (3558.03, 317.44, 3600.87, 0.0, 0.0, -146.43)),
        _body("link 4", 0.41737, (0.0, -0.032302, -0.059705), (329.34, 272.54, 258.94, 0.0, 0.0, -63.11)),
        _body("link 5", 0.41737, (0.0, -0.032302, -0.059705), (329.34, 272.54, 258.94, 0.0, 0.0, -63.11)),
        _body("link 6", 0.727, (0.0, -0.00684, -0.08222), (1153.86, 783.58, 1016.25, 4.20, -6.54, -56.89)),
    )


def jaco2_parts() -> tuple[tuple[Body, ...], ...]:
    """The parts of the base and of links 1 … 6: shell, actuator, ring; palm, and two phalanges for each finger."""
    lean = (0.0, np.sin(np.pi / 3), np.cos(np.pi / 3))
    joint_5 = (0.0, -0.03705, -0.0641724824)
    wrist = (78.928, 78.169, 53.449, 0.0, 0.0, -13.471)
    shells = (
        _body("shell 0", 0.640, (0.0, 0.0, 0.096902), (3068.815, 3072.555, 853.961, 0.0, 0.0, 1.28)),
        _body(
            "shell 1", 0.181984, (1.74e-4, -0.010349, -0.094041), (825.890, 845.413, 209.955, -0.287, 0.593, -25.515)
        ),
        _body(
            "shell 2", 0.423993, (-3.3e-5, -0.217190, -0.022265), (10861.45, 330.890, 11013.616, -1.58, 0.182, 42.475)
        ),
        _body(
            "shell 3", 0.211004, (1.03e-4, 0.064422, -0.027432), (692.649, 134.297, 746.316, -1.946, -0.240, 153.622)
        ),
        _body("shell 4", 0.06896, (0.0, -0.008313, -0.037134), wrist),
        _body("shell 5", 0.06896, (0.0, -0.008313, -0.037134), wrist),
    )
    actuators = (
        _actuator(1, 0.57368, 0.012, (0.0, 0.0, 0.15675), (0.0, 0.0, 1.0), LARGE),
        _actuator(2, 0.55972, 0.012, (0.0, 0.0016, -0.11875), (0.0, 1.0, 0.0), LARGE),
        _actuator(3, 0.573341, 0.012, (0.0, -0.410, 0.0), (0.0, 0.0, 1.0), LARGE),
        _actuator(4, 0.34141, 0.007, (0.0, 0.2073, -0.0114), (0.0, 1.0, 0.0), SMALL),
        _actuator(5, 0.34141, 0.007, joint_5, lean, SMALL),
        _actuator(6, 0.34141, 0.007, joint_5, lean, SMALL),
    )
    return (*((shell, *pair) for shell, pair in zip(shells, actuators, strict=True)), _hand())


def jaco2_augmented_links() -> tuple[Body, ...]:
    """`jaco2_links` again, built up from `jaco2_parts`. Source: thesis A, 3.3.2."""
    return tuple(combine(parts, link.name) for parts, link in zip(jaco2_parts(), jaco2_links(), strict=True))


def finger_frames() -> tuple[Array, ...]:
    """Frames of the three fingers, link 6 ← finger, (4, 4) [m]: x along the open finger, z its joint, which closes it.

    The first is the thumb. Source: vendor's description.
    """
    return (
        _frame((0.00279, 0.03126, -0.11467), (-1.7047873384941834, 0.6476144647144773, 1.67317415161155)),
        _frame((0.02226, -0.02707, -0.11482), (-1.570796327, 0.649262481663582, -1.38614049188413)),
        _frame((-0.02226, -0.02707, -0.11482), (-1.570796327, 0.649262481663582, -1.75545216211587)),
    )


def _body(name: str, mass: float, com: tuple[float, float, float], inertia: tuple[float, ...]) -> Body:
    """A body from (xx, yy, zz, xy, xz, yz) in 1e-6 kg·m² = kg·mm², as tables print it."""
    xx, yy, zz, xy, xz, yz = inertia
    tensor = 1e-6 * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Body(name=name, mass=mass, com=np.array(com), inertia=tensor)


def _actuator(
    number: int,
    mass: float,
    ring_mass: float,
    joint: tuple[float, float, float],
    axis: tuple[float, float, float],
    size: tuple[float, float],
) -> tuple[Body, Body]:
    """An actuator, solid and centred on its joint, and the plastic ring, a hoop of its diameter around it."""
    com, along = np.array(joint), np.array(axis)
    diameter, length = size
    actuator = solid_cylinder(
        name=f"actuator {number}", mass=mass, com=com, axis=along, diameter=diameter, length=length
    )
    return actuator, hoop(name=f"ring {number}", mass=ring_mass, com=com, axis=along, diameter=diameter)


def _hand() -> tuple[Body, ...]:
    """Palm and three open fingers of the KG-3 hand.

    Masses of the phalanges and form of the palm's tensor: vendor's CAD; finger frames: vendor's description. The
    palm's mass and centre of mass are what the hand's 0.727 kg and its centre of mass leave.
    """
    palm = _body(
        "palm", 0.661549, (7.1645e-5, -0.005534372, -0.077120113), (653.842, 537.971, 681.154, 0.0, -3.3106, -2.4829)
    )
    proximal = _body("proximal", 0.009127, (0.0204, -0.0082, 0.0), (0.725662, 2.470995, 2.464460, -0.002343, 0.0, 0.0))
    distal = _body("distal", 0.01269, (0.0574, -0.0078, 0.0), (0.650426, 2.630881, 2.465798, -0.023954, 0.0, 0.0))
    return (palm, *(bone.seen_from(T) for T in finger_frames() for bone in (proximal, distal)))


def _frame(xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> Array:
    """Homogeneous transform from a description's xyz [m] and roll, pitch, yaw [rad]."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return T
