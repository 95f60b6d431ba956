"""Thesis B, 5.2.6: the hybrid law, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_13, hybrid

EXPERIMENT = robot_experiment(
    title="Hybrid, honest arm",
    source="Thesis B, 5.2.6, table 5.13, figure 5.13",
    about="""The thesis made it to keep position and orientation apart.""",
    claim="The thesis: smaller steady error, less coupling than all before.",
    theirs=lambda: hybrid(TABLE_5_13),
    same=ours.hybrid,
)
