"""One step of a peer, timed in that peer's own environment; `peers.py` talks to it over its standard streams.

Each line in is a number of steps; each line out their times [µs] as JSON. The step is what the peer would do in a
control cycle: its model at a new joint position, then its law or its solver.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from time import perf_counter_ns

Step = Callable[[int], object]
"""The work of one cycle, given its number."""


def mink_step(description: str) -> Step:
    """mink: the configuration at q, then `solve_ik` with a pose task and the joint limits."""
    import mink
    import mujoco
    import numpy as np

    model = mujoco.MjModel.from_xml_path(description)
    configuration = mink.Configuration(model)
    task = mink.FrameTask("end_effector", "body", position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)
    limits = [mink.ConfigurationLimit(model)]
    rng = np.random.default_rng(0)
    states = np.array([4.8, 2.9, 1.0, 4.2, 1.4, 1.3]) + 0.1 * rng.standard_normal((64, model.nv))
    configuration.update(states[0])
    task.set_target_from_configuration(configuration)

    def step(number: int) -> object:
        configuration.update(states[number % 64])
        return mink.solve_ik(configuration, [task], 0.01, solver="daqp", damping=1e-3, limits=limits)

    return step


def robosuite_step(description: str) -> Step:
    """robosuite: OSC_POSE of its UR5e, `run_controller` with a new state."""
    import robosuite
    from robosuite.controllers import load_composite_controller_config

    config = load_composite_controller_config(controller="BASIC", robot="UR5e")
    environment = robosuite.make(
        "Lift",
        robots="UR5e",
        controller_configs=config,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
    )
    environment.reset()
    arm = environment.robots[0].composite_controller.part_controllers["right"]

    def step(number: int) -> object:
        arm.new_update = True
        return arm.run_controller()

    return step


STEPS: dict[str, Callable[[str], Step]] = {"mink": mink_step, "robosuite": robosuite_step}


def main() -> int:
    """Answer until the input ends."""
    name, description = sys.argv[1:]
    out = sys.stdout
    # What the peer prints goes to the log, not into the answers.
    sys.stdout = sys.stderr
    step = STEPS[name](description)
    for number in range(200):
        step(number)
    print("ready", file=out, flush=True)
    for line in sys.stdin:
        times = []
        for number in range(int(line)):
            start = perf_counter_ns()
            step(number)
            times.append(1e-3 * (perf_counter_ns() - start))
        print(json.dumps(times), file=out, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
