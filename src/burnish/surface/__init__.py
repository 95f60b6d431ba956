"""The mould: its triangles, the distance to it, and where it can be worked."""

from burnish.surface.access import Access
from burnish.surface.border import Border
from burnish.surface.distance import DistanceGrid
from burnish.surface.files import read_mesh
from burnish.surface.mould import Mould
from burnish.surface.regions import Region, edge_band, regions
from burnish.surface.touch import Touch, laid, lowered, top, touching, unobstructed
from burnish.surface.units import METRES_PER_UNIT
from burnish.surface.working import WorkingSurface, refine, vertex_areas

__all__ = [
    "METRES_PER_UNIT",
    "Access",
    "Border",
    "DistanceGrid",
    "Mould",
    "Region",
    "Touch",
    "WorkingSurface",
    "edge_band",
    "laid",
    "lowered",
    "read_mesh",
    "refine",
    "regions",
    "top",
    "touching",
    "unobstructed",
    "vertex_areas",
]
