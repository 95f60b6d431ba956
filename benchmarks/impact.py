"""Unexpected contacts: the honest arm meets a head, free to move, at the speed that the supervisor allows.

Each contact has its own arm (masses ± 10 %, rotors and friction ± 30 %), pose, direction and way to the head. The tool
is driven along a straight line into a mass on a spring: at nine tenths of the allowed speed, which it overshoots up to
the whole, and at twice that speed, where the supervisor stops it, often before it is there. The force is the spring's,
at the rate of the physics.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import machine, text_table, write_json
from joblib import Parallel, delayed

from burnish.control import OperationalSpace
from burnish.core import Array, Dynamics, State, ToolReference
from burnish.model.model import Model
from burnish.runtime.clearance import Clearance
from burnish.runtime.guards import allowed_speed
from burnish.runtime.limits import Limits
from burnish.runtime.loop import Rig, control
from burnish.runtime.supervisor import Supervisor
from burnish.sim import arms
from burnish.sim.robot import SimRobot
from burnish.sim.scene import TIMESTEP

PEAK, AFTER = 65.0, 40.0
"""Goals: peak force, and force half a second after the first touch [N]."""
RATE = 100.0
EASY = 0.5
"""Share of the joints' speed limits at the start: they move faster on the way, and must not stop the arm first."""
AWAY = (0.002, 0.06)
"""Way to the head [m]: it is met while the tool speeds up, at its fastest, and in a hold."""
LEAST_MANIPULABILITY = 0.02
"""Smallest singular value of J at which a pose is taken: next to a singularity nothing goes straight."""


class RobotWithHead(SimRobot):
    """The bare simulated arm with a head before its tool frame: a mass on a spring, free along the way."""

    def __init__(self, q: Array, along: Array, way: float, limits: Limits, **options: Any) -> None:
        super().__init__(q, **options)
        self._along, self._limits = along, limits
        # The frame of the physics is the base's where there is no mould.
        self._place = float(self._tip_centre @ along) + way
        self._speed = 0.0
        self.force: list[float] = []

    def _touch(self) -> None:
        """The spring's force on the hand, and the head's motion; called once a physics step."""
        depth = float(self._tip_centre @ self._along) - self._place
        force = self._limits.impact_stiffness * max(0.0, depth)
        self._on_hand[:3] = -force * self._along
        self._speed += force / self._limits.impact_mass * TIMESTEP
        self._place += self._speed * TIMESTEP
        self.force.append(force)


@dataclass(kw_only=True)
class Straight:
    """A straight line at a share of the allowed speed, reached within a quarter of a second."""

    along: Array
    share: float
    limits: Limits

    def reset(self, arm: Dynamics) -> None:
        self.p, self.R, self.t, self.start, self.way = arm.p, arm.R, arm.t, arm.t, 0.0

    def at(self, arm: Dynamics) -> ToolReference:
        speed = self.share * allowed_speed(self.limits, arm, self.along) * min(1.0, (arm.t - self.start) / 0.25)
        self.way += speed * (arm.t - self.t)
        self.t = arm.t
        v = np.concatenate([speed * self.along, np.zeros(3)])
        return ToolReference(p=self.p + self.way * self.along, R=self.R, v=v, a=np.zeros(6))


def start_of(model: Model, limits: Limits, rng: np.random.Generator) -> tuple[Array, Array]:
    """Joint positions and a direction in which the tool is as fast as allowed while no joint is."""
    low, high = limits.within(0.4, 0.2)
    clearance = Clearance(limits)
    while True:
        q = np.where(np.isfinite(low), rng.uniform(np.maximum(low, -9.0), np.minimum(high, 9.0)), rng.uniform(0, 6, 6))
        along = rng.normal(size=3)
        along /= np.linalg.norm(along)
        arm = model.at(State(t=0.0, q=q, dq=np.zeros(6)))
        if np.linalg.svd(arm.J, compute_uv=False)[-1] < LEAST_MANIPULABILITY or clearance.measure(arm) < 0.1:
            continue
        dq = np.linalg.solve(arm.J, np.concatenate([limits.free_speed * along, np.zeros(3)]))
        if np.all(np.abs(dq) < EASY * limits.speed):
            return q, along


def contact(seed: int, share: float) -> dict[str, Any]:
    """One contact: its forces [N] and speeds [m/s]."""
    rng = np.random.default_rng([seed, 3])
    arm, limits = arms.honest(seed), Limits.jaco2()
    model = Model.jaco2().with_armature(arm.armature)
    q, along = start_of(model, limits, rng)
    way = float(rng.uniform(*AWAY))
    robot = RobotWithHead(q, along, way, limits, rate=RATE, plant=arm.plant)
    supervisor = Supervisor(limits=limits, period=1.0 / RATE)
    law = OperationalSpace(kp=400.0, kd=40.0)
    touched: dict[str, Any] = {}

    def over(now: Dynamics) -> bool:
        if not touched and max(robot.force, default=0.0) > 0.0:
            v = float(now.v[:3] @ along)
            touched.update(t=now.t, allowed=allowed_speed(limits, now, along), after=v)
        return now.t > (touched["t"] + 0.7 if touched else 4.0)

    before = 0.0
    source = Straight(along=along, share=share, limits=limits)
    for sample in control(Rig(robot, model, supervisor), source, law, until=over):
        if not touched:
            before = float(np.linalg.norm(sample.arm.v[:3]))
    force = np.array(robot.force)
    first = int(np.argmax(force > 0.0))
    event = supervisor.event
    return {
        "seed": seed,
        "touched": bool(touched),
        "peak": float(force.max()),
        "after": float(force[first + round(0.5 / TIMESTEP) :].max()) if touched else 0.0,
        "speed": before,
        "allowed": touched.get("allowed", 0.0),
        "held": event is not None and (not touched or event.t < touched["t"]),
        "softened": supervisor.softened > 0,
        "cause": "" if event is None else event.cause,
    }


def main() -> int:
    """Measure and print; 0 if the goals are met."""
    cli = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    cli.add_argument("--contacts", type=int, default=1000, metavar="N", help="of each kind (default: 1000)")
    cli.add_argument("--jobs", type=int, default=1, metavar="J", help="processes (default: 1)")
    cli.add_argument("--out", type=Path, metavar="FILE.json", help="file for the result (default: table only)")
    options = cli.parse_args()
    result: dict[str, Any] = {}
    rows = []
    for name, share in (("at the allowed speed", 0.9), ("pushed beyond it", 2.0)):
        found = Parallel(n_jobs=options.jobs)(delayed(contact)(seed, share) for seed in range(options.contacts))
        met = [f for f in found if f["touched"]]
        peak, after = (np.array([f[key] for f in met]) for key in ("peak", "after"))
        shares = np.array([f["speed"] / f["allowed"] for f in met])
        result[name] = {
            "runs": len(found),
            "contacts": len(met),
            "held_before": sum(f["held"] for f in found),
            "softened": sum(f["softened"] for f in found),
            "peak_p50_N": float(np.median(peak)),
            "peak_p99.9_N": float(np.percentile(peak, 99.9)),
            "peak_max_N": float(peak.max()),
            "after_p99.9_N": float(np.percentile(after, 99.9)),
            "speed_p50_mps": float(np.median([f["speed"] for f in met])),
            "share_of_allowed_p50": float(np.median(shares)),
            "share_of_allowed_p99.9": float(np.percentile(shares, 99.9)),
            "worst": sorted(met, key=lambda f: -f["peak"])[:5],
        }
        print(f"{name}: done", flush=True)
        rows.append([name] + [f"{v:.3g}" for v in result[name].values() if not isinstance(v, list)])
    print(text_table(["kind", *(k for k, v in result["pushed beyond it"].items() if not isinstance(v, list))], rows))
    met_goal = all(r["peak_p99.9_N"] <= PEAK and r["after_p99.9_N"] <= AFTER for r in result.values())
    print(f"goal: p99.9 of the peak ≤ {PEAK:g} N, ≤ {AFTER:g} N after 0.5 s: {'met' if met_goal else 'missed'}")
    if options.out:
        write_json(options.out, {"machine": machine(), "goal_met": met_goal, "found": result})
    return 0 if met_goal else 1


if __name__ == "__main__":
    raise SystemExit(main())
