"""The mould: its triangles, the distance to it, and where it can be worked."""

from burnish.surface.border import Border
from burnish.surface.distance import DistanceGrid
from burnish.surface.mould import Mould
from burnish.surface.stl import METRES_PER_UNIT, read_stl
from burnish.surface.touch import Touch, laid, lowered, top, touching, unobstructed
from burnish.surface.working import WorkingSurface, refine, vertex_areas

__all__ = [
    "METRES_PER_UNIT",
    "Border",
    "DistanceGrid",
    "Mould",
    "Touch",
    "WorkingSurface",
    "laid",
    "lowered",
    "read_stl",
    "refine",
    "top",
    "touching",
    "unobstructed",
    "vertex_areas",
]
