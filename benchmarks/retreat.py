"""How soon any torque within the supervisor's clamps could take the tool off the surface after too much force.

With the mould in its place and the pose of the trip, x the way of the tool off the surface and f = f_0 − k x:

    ẍ = Σ b_j (τ_j − g_j) + f/m,    b = J_n M⁻¹,    1/m = J_n M⁻¹ J_nᵀ

Nothing else enters, so the soonest way off is that of the largest Σ b_j (τ_j − g_j) at every instant: each joint as
fast as its rate clamp allows to the end of what it may differ from gravity. Friction, which only slows it, is left out.

    python benchmarks/retreat.py
"""

from __future__ import annotations

import argparse

import numpy as np
from common import text_table

from burnish.control.force import with_felt
from burnish.core import Array, State
from burnish.model.ik import inverse_kinematics
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import READY, nominal_placement, tool_down
from burnish.runtime.limits import Limits
from burnish.sim import arms
from burnish.surface import Mould

FORCE = 25.0
"""At which it trips [N]."""
STEP = 1e-5
"""Of the integration [s]."""
LONGEST = 0.5
"""When it is given up [s]."""


def soonest(b: Array, mass: float, stiffness: float, before: Array, after: Array, rate: float, late: float) -> float:
    """Time until f = 0 [s], when each joint's torque goes from ``before`` to ``after`` [N·m] at ``rate`` [N·m/s].

    Args:
        b: what a torque of each joint does to the tool along the normal [m/s² per N·m], (n,).
        mass: felt at the tool [kg].
        stiffness: of tip and felt [N/m].
        before: difference from gravity at the trip [N·m], (n,).
        after: the one that it goes to [N·m], (n,).
        rate: largest change of a torque [N·m/s].
        late: from the trip until the first torque of the retreat acts [s].
    """
    x, v, tau = 0.0, 0.0, before.copy()
    for t in np.arange(0.0, LONGEST, STEP):
        force = FORCE - stiffness * x
        if force <= 0.0:
            return float(t)
        if t >= late:
            tau = tau + np.clip(after - tau, -rate * STEP, rate * STEP)
        v += STEP * (float(b @ tau) + force / mass)
        x += STEP * v
    return np.inf


def main() -> int:
    """Print the bounds."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    tool, limits = PolishingTool(), Limits.jaco2()
    model = tool.on(Model.jaco2()).with_armature(arms.honest(1).armature)
    top = float(Mould.load("plate").vertices[:, 2].max())
    over = nominal_placement(top).points(np.array([[0.0, 0.0, top]]))[0]
    q = inverse_kinematics(model, over, tool_down(model), READY)
    arm = model.at(State(t=0.0, q=q, dq=np.zeros(model.n)))
    n = arm.J[2]
    b = np.linalg.solve(arm.M, n)
    mass, stiffness = 1.0 / float(b @ n), with_felt(tool.stiffness)
    before, most = -FORCE * n, np.sign(b) * limits.deviation
    lines = []
    for name, after, rate in (
        ("every joint to its clamp", most, limits.torque_rate),
        ("no push any more, at once", 0.0 * n, np.inf),
        ("every joint to its clamp, at once", most, np.inf),
    ):
        times = [soonest(b, mass, stiffness, before, after, rate, late) for late in (0.020, 0.002)]
        lines.append([name, f"{rate:g}", *(f"{1e3 * time:.0f}" for time in times)])
    print(f"{mass:.1f} kg behind {stiffness / 1e3:.1f} kN/m; {FORCE:g} N at the trip, two cycles until a torque acts")
    print(text_table(["retreat", "rate [N·m/s]", "100 Hz [ms]", "1 kHz [ms]"], lines))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
