"""What needs a recording, not a robot: figures, plots, pictures and reports."""

from burnish.analysis.metrics import PassMetrics, PassSeries, pass_metrics, write_metrics
from burnish.analysis.mould_map import RemovalField, removal_colours
from burnish.analysis.plot import RunSeries
from burnish.analysis.render import Camera
from burnish.analysis.report import Event, RunReport, write_report
from burnish.analysis.scene import Scene
from burnish.analysis.shape import CARBON, FELT, PATH, STEEL, TRACE, Shape, thin, tube

__all__ = [
    "CARBON",
    "FELT",
    "PATH",
    "STEEL",
    "TRACE",
    "Camera",
    "Event",
    "PassMetrics",
    "PassSeries",
    "RemovalField",
    "RunReport",
    "RunSeries",
    "Scene",
    "Shape",
    "pass_metrics",
    "removal_colours",
    "thin",
    "tube",
    "write_metrics",
    "write_report",
]
