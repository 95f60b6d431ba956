"""Thesis B, 5.2.2: computed torque in task space, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_9, task_computed_torque

EXPERIMENT = robot_experiment(
    title="Computed torque in task space, honest arm",
    source="Thesis B, 5.2.2, table 5.9, figure 5.9",
    about="""As in simulation, with the enlarged hand.""",
    claim="The thesis: acceptable steady error, position and orientation disturb each other.",
    theirs=lambda: task_computed_torque(TABLE_5_9),
    same=ours.task_computed_torque,
)
