"""Small things to put into a library, each made as burnish makes it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from commands.test_cli import small_plate
from record.samples import record, tool_sample
from teach.cells import shown
from teach.test_demonstration import recorded, stored

from burnish.paths.stroke import Stroke
from burnish.polish.journal import NAME, Journal, Mark
from burnish.polish.plan_file import write_plan
from burnish.polish.recipe import Recipe
from burnish.polish.recipe_file import write_recipe
from burnish.surface import Mould


def mould(folder: Path, size: float = 30.0) -> Path:
    """An STL file."""
    return small_plate(folder / f"plate {size:g}.stl", size)


def recipe(folder: Path, force: float = 10.0) -> Path:
    """A recipe's file."""
    path = folder / f"force {force:g}.toml"
    write_recipe(Recipe(force=force), path)
    return path


def plan(folder: Path) -> Path:
    """A plan's file: a line of 20 mm at 20 mm/s."""
    points = np.column_stack([np.linspace(0.0, 0.02, 41), np.zeros(41), np.full(41, 0.01)])
    even = np.ones(41)
    line = Stroke(points=points, normals=np.tile([0.0, 0.0, 1.0], (41, 1)), feed=0.02 * even, force=10.0 * even)
    write_plan(folder / "plan.json", [line], Mould.load(str(mould(folder))), Recipe())
    return folder / "plan.json"


def demonstration(folder: Path) -> Path:
    """A recording of a demonstration."""
    wanted = shown()
    recorded(folder / "shown.mcap", wanted, stored(wanted), mould="dome", mould_sha256="d" * 64, device="a hand")
    return folder / "shown.mcap"


def job(folder: Path, seed: int = 0, cut: bool = False, **figures: object) -> Path:
    """The folder of a job; ``cut`` is what a killed one leaves."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    about = {"verb": "polish", "mould": "dome", "mould_sha256": "d" * 64, "arm": "honest", "sensor": "wrist"}
    path = record(folder / "run.mcap", [tool_sample(rng, 0.01 * i) for i in range(300)], **about)
    with Journal(folder / NAME, {"order": {}, "course": {}, "mould_sha256": "d" * 64}) as journal:
        journal.add(Mark(number=1, stroke=1, s=0.06, phase="pass", force=10.0, t=4.0, metres=0.06, joules=0.18))
    if cut:
        path.write_bytes(path.read_bytes()[:-20_000])
    else:
        metrics = {"force_rms_N": 0.5, "duration_s": 3.0, "mould": "dome"} | figures
        (folder / "metrics.json").write_text(json.dumps(metrics))
        (folder / "report.html").write_text(f"<p>{seed}</p>")
    return folder


def campaign(folder: Path) -> Path:
    """The folder of a campaign."""
    folder.mkdir(parents=True)
    told = {"episodes": 3, "virtual_hours": 0.5, "by_fault": {"none": 1}, "interrupted": True}
    (folder / "campaign.json").write_text(json.dumps(told))
    (folder / "settings.json").write_text('{"seed": 3}')
    (folder / "report.html").write_text("<p>3 episodes</p>")
    return folder
