"""From a file to a row: each kind is read by whoever knows it, and refused where it is not what it says."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path, PurePath

import numpy as np

from burnish.analysis.scene import Scene
from burnish.analysis.shape import STEEL, Shape
from burnish.core import Array
from burnish.library.rows import (
    LONGEST_NAME,
    DemonstrationRow,
    MouldRow,
    PlanRow,
    RecipeRow,
    ToolRow,
    identity,
    one_line,
)
from burnish.library.storage import Source, written
from burnish.model.tool import PolishingTool
from burnish.polish import plan_file, recipe_file
from burnish.polish.recipe_file import as_tables, read_recipe
from burnish.record.described import described, fingerprint
from burnish.record.recording import Recording
from burnish.surface import Mould, files
from burnish.teach.demonstration import Demonstration

MESHES = (".stl", ".obj", ".ply", ".3mf")
"""Endings of a mould's file."""
LARGEST_RECORDING = 4 * 2**30
"""Of a recording [B]: a day at 100 Hz."""
THUMBNAIL = (320, 240)
"""Width and height of a mould's picture [px]."""
MOST_DRAWN = 100_000
"""Triangles that are drawn as they are."""
CELLS = 128
"""Of the grid for more, along the longest side."""
AUTO = "auto"
"""The unit of a mould's file is found out from its size."""


def read_mould(source: Source, folder: Path, unit: str) -> MouldRow:
    """A mould and its picture.

    Raises:
        MouldError: it is no surface that can be worked.
    """
    stem = PurePath(source.called)
    ending = stem.suffix.lower() if stem.suffix.lower() in MESHES else MESHES[0]
    mesh = source.copied(folder, "mesh", ending, files.MAX_BYTES)
    with source.reading(mesh, folder) as path:
        mould = Mould.load(str(path), None if unit == AUTO else unit)
    picture = written([thumbnail(mould)], folder, "thumbnail", ".png")
    return MouldRow(
        id=identity(MouldRow, mould.sha256),
        name=stem.stem,
        created=now(),
        files=(mesh, picture),
        geometry=mould.sha256,
        unit=unit,
        size=tuple(np.ptp(mould.vertices, axis=0).tolist()),
        triangles=len(mould.faces),
        warnings=tuple(one_line(sentence.replace(str(path), source.called), 500) for sentence in mould.warnings),
    )


def thumbnail(mould: Mould) -> bytes:
    """A picture of a mould as a PNG file."""
    vertices, faces = mould.vertices, mould.faces
    if len(faces) > MOST_DRAWN:
        # Corners in one cell of a grid are one: coarser than the picture's pixels, and it does not take minutes.
        grid = np.rint((vertices - vertices.min(axis=0)) / np.ptp(vertices, axis=0).max() * CELLS).astype(np.int64)
        _, first, cell = np.unique(grid @ [(CELLS + 1) ** 2, CELLS + 1, 1], return_index=True, return_inverse=True)
        faces = cell[faces]
        vertices, faces = vertices[first], faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    shape = Shape(name="mould", vertices=vertices, faces=faces, colour=np.array(STEEL))
    return Scene.of([shape]).still(*THUMBNAIL)


def read_tool(tool: PolishingTool, folder: Path, name: str) -> ToolRow:
    """A tool, with all its figures in a file."""
    stored = written([described(tool).encode()], folder, "tool", ".json")
    return ToolRow(
        id=identity(ToolRow, fingerprint(tool)),
        name=name,
        created=now(),
        files=(stored,),
        fingerprint=fingerprint(tool),
        tip_radius=tool.tip_radius,
        length=tool.length,
        stiffness=tool.stiffness,
        modulus=tool.modulus,
        friction=tool.friction,
    )


def read_recipe_row(source: Source, folder: Path) -> RecipeRow:
    """A recipe.

    Raises:
        InputError: it is none.
    """
    stored = source.copied(folder, "recipe", ".toml", recipe_file.MAX_BYTES)
    with source.reading(stored, folder) as path:
        recipe = read_recipe(path)
    passes = as_tables(recipe).get("passes", [])
    return RecipeRow(
        id=identity(RecipeRow, stored.sha256),
        name=PurePath(source.called).stem,
        created=now(),
        files=(stored,),
        force=recipe.force,
        feed=recipe.feed,
        passes=max(1, len(passes)),
        patterns=", ".join(dict.fromkeys(one["pattern"] for one in passes)) or "raster",
        grit=one_line(recipe.grit, LONGEST_NAME),
        tool=fingerprint(recipe.tool),
    )


def read_plan_row(source: Source, folder: Path) -> PlanRow:
    """A plan.

    Raises:
        PlanError: it is none.
    """
    stored = source.copied(folder, "plan", ".json", plan_file.MAX_BYTES)
    with source.reading(stored, folder) as path:
        plan = plan_file.load_plan(path)
    return PlanRow(
        id=identity(PlanRow, stored.sha256),
        name=PurePath(source.called).stem,
        created=now(),
        files=(stored,),
        mould_sha256=plan.made_for or "",
        strokes=len(plan.strokes),
        length=sum(stroke.length for stroke in plan.strokes),
        duration=sum(_duration(stroke.points, stroke.feed) for stroke in plan.strokes),
    )


def read_demonstration(source: Source, folder: Path) -> DemonstrationRow:
    """A demonstration: a recording of ``burnish teach`` in which something was stored.

    Raises:
        RecordingError: it is none.
    """
    stored = source.copied(folder, "recording", ".mcap", LARGEST_RECORDING)
    with source.reading(stored, folder) as path:
        recording = Recording(path)
        shown = Demonstration.of(recording)
    about = {name: one_line(value, LONGEST_NAME) for name, value in recording.metadata.items()}
    force = np.linalg.norm(shown.F[shown.contact, :3], axis=1)
    mould, device = about.get("mould", ""), about.get("device", "")
    return DemonstrationRow(
        id=identity(DemonstrationRow, stored.sha256),
        name=f"{mould}, by {device}",
        created=now(),
        files=(stored,),
        mould=mould,
        mould_sha256=about.get("mould_sha256", ""),
        arm=about.get("arm", ""),
        device=device,
        duration=float(shown.t[-1]),
        cycles=len(shown.t),
        contact=float(np.mean(shown.contact)),
        force_most=float(force.max(initial=0.0)),
    )


def now() -> datetime:
    """The time, UTC."""
    return datetime.now(timezone.utc)


def _duration(points: Array, feed: Array) -> float:
    """Time along a stroke [s]: the mean feed of both ends over each piece."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return float(np.sum(2.0 * step / (feed[1:] + feed[:-1])))
