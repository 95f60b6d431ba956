"""Thesis B, 5.2.7: the hybrid law with null space, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_14, hybrid_null_space

EXPERIMENT = robot_experiment(
    title="Hybrid with null space, honest arm",
    source="Thesis B, 5.2.7, table 5.14, figure 5.14",
    about="""The thesis polished with this one.""",
    claim="The thesis: the best of its laws, least coupling, smaller steady error.",
    theirs=lambda: hybrid_null_space(TABLE_5_14),
    same=ours.hybrid_null_space,
)
