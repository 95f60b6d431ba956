"""The library: moulds, tools, recipes, demonstrations, plans and runs, kept as files and found in a database."""

from burnish.library.audit import Finding, Rebuilt
from burnish.library.library import Library
from burnish.library.rows import (
    DemonstrationRow,
    MouldRow,
    PlanRow,
    RecipeRow,
    Row,
    RunRow,
    Scalar,
    Stored,
    ToolRow,
)

__all__ = [
    "DemonstrationRow",
    "Finding",
    "Library",
    "MouldRow",
    "PlanRow",
    "Rebuilt",
    "RecipeRow",
    "Row",
    "RunRow",
    "Scalar",
    "Stored",
    "ToolRow",
]
