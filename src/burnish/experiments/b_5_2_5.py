"""Thesis B, 5.2.5: impedance with force sensing for redundant robots, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_12, redundant

EXPERIMENT = robot_experiment(
    title="Impedance with force sensing for redundant robots, A = Λ, honest arm",
    source="Thesis B, 5.2.5, table 5.12, figure 5.12",
    about="""The law of 5.2.4 by Λ in the place of J⁻¹.""",
    claim="The thesis: acceptable steady error, coupling as in 5.2.4.",
    theirs=lambda: redundant(TABLE_5_12),
    same=ours.redundant,
)
