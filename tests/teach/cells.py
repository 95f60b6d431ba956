"""A cell that is quick to make, and demonstrations for it that no arm had to show."""

from __future__ import annotations

from functools import cache

import numpy as np

from burnish.core import Array
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.polish.cell import nominal_placement, tool_down
from burnish.polish.cellsim import WristFelt
from burnish.sim import arms
from burnish.sim.arms import Arm
from burnish.surface import DistanceGrid, Mould, bundled
from burnish.teach.demonstration import Demonstration
from burnish.teach.simulated import Cell

TOOL = PolishingTool()
RADIUS = bundled.DOME_RADIUS


@cache
def dome() -> tuple[Mould, DistanceGrid]:
    mould = Mould.load("dome")
    return mould, DistanceGrid.of(mould, 2e-3)


def cell_of(arm: Arm | None = None) -> Cell:
    mould, grid = dome()
    arm = arms.honest(1) if arm is None else arm
    return Cell.of(arm, mould, grid, 100.0, WristFelt(), TOOL)


def shown(
    *, shift: Array | None = None, noise: float = 0.0, seed: int = 0, times: float = 1.0, lost: bool = False
) -> Demonstration:
    """Idle, down, 40 mm along the dome at 20 mm/s with 8 + 3 sin N, up, idle; at 100 Hz.

    Args:
        shift: where the mould really stood, less where it was meant to, base axes [m].
        noise: of force [N] and, a ten-thousandth of it, of position [m].
        seed: of the noise.
        times: as long.
        lost: whether the contact is lost for 0.1 s in the middle.
    """
    rng = np.random.default_rng(seed)
    mould = dome()[0]
    placement = nominal_placement(float(mould.vertices[:, 2].max()))
    dt, height = 0.01, 0.03
    parts = [(np.full(100, -0.02), np.full(100, height), np.zeros(100))]
    down = np.linspace(height, 0.0, 150)
    parts.append((np.full(150, -0.02), down, np.zeros(150)))
    count = round(200 * times)
    x = np.linspace(-0.02, 0.02, count)
    force = 8.0 + 3.0 * np.sin(np.pi * x / 0.02)
    parts.append((x, np.zeros(count), force))
    parts.append((np.full(150, 0.02), down[::-1], np.zeros(150)))
    parts.append((np.full(100, 0.02), np.full(100, height), np.zeros(100)))
    x, up, force = (np.concatenate(column) for column in zip(*parts, strict=True))
    normal = np.column_stack([x, np.zeros_like(x), np.sqrt(RADIUS**2 - x**2)]) / RADIUS
    top = float(mould.vertices[:, 2].max())
    point = RADIUS * normal + [0.0, 0.0, top - RADIUS]
    # Pressed, the tip gives way; the tool stays upright in the mould's frame.
    down_axis = placement.R.T @ tool_down(TOOL.on(Model.jaco2()))
    axis = down_axis[:, 2]
    pressed = force * -(normal @ axis) / TOOL.stiffness
    centre = point + (TOOL.tip_radius + up)[:, None] * normal
    p = centre + (TOOL.tip_radius + pressed)[:, None] * axis
    if shift is not None:
        p = p + placement.R.T @ shift
    p = p + 1e-4 * noise * rng.standard_normal(p.shape)
    F = np.zeros((len(x), 6))
    F[:, :3] = force[:, None] * normal + noise * rng.standard_normal((len(x), 3))
    contact = force > 0.0
    if lost:
        contact[250 + count // 2 : 260 + count // 2] = False
    return Demonstration(
        t=dt * np.arange(len(x)),
        p=p,
        R=np.repeat(down_axis[None], len(x), axis=0),
        p_d=p,
        R_d=np.repeat(down_axis[None], len(x), axis=0),
        F=F,
        contact=contact,
        mode=np.full(len(x), "polishing", dtype=object),
        gains="",
        placement=placement,
    )
