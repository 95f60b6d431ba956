"""Thesis B, 5.2.4: impedance with force sensing, on the robot."""

from burnish.experiments import ours
from burnish.experiments.on_robot import robot_experiment
from burnish.experiments.thesis_b import TABLE_5_11, force_sensing

EXPERIMENT = robot_experiment(
    title="Impedance with force sensing, A = Λ, honest arm",
    source="Thesis B, 5.2.4, table 5.11, figure 5.11",
    about="""With A = Λ M cancels, but for the feed-forward.""",
    claim="The thesis: acceptable steady error, coupling a little less.",
    theirs=lambda: force_sensing(TABLE_5_11),
    same=ours.force_sensing,
)
