"""Thesis B, 5.2.3: impedance without force sensing, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_10, impedance

EXPERIMENT = robot_experiment(
    title="Impedance without force sensing, honest arm",
    source="Thesis B, 5.2.3, table 5.10, figure 5.10",
    about="""M is not in this law, so the enlarged hand is not either.""",
    claim="The thesis: small steady error, position and orientation disturb each other.",
    theirs=lambda: impedance(TABLE_5_10),
    same=ours.impedance,
)
