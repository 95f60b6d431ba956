"""Lines at equal distances on the surface itself, by the heat method.

The distance u over the surface from a seed line follows from two sparse solves: heat that flows from the line for a
short time gives the direction −∇h/|∇h| of growing distance, and a Poisson equation the distance that has it.

Source: K. Crane, C. Weischedel, M. Wardetzky, "Geodesics in Heat", ACM Trans. Graph. 32(5), 2013.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.paths.sheet import Sheet


def distance_over(sheet: Sheet, island: NDArray[np.bool_], seed: NDArray[np.bool_]) -> Array:
    """Distance over the surface from the seed to each place of an island [m], (ny, nx); NaN elsewhere.

    Both are (ny, nx). Places that hang on the others by a corner only have no distance.
    """
    import potpourri3d

    number = np.full(island.shape, -1, dtype=np.int64)
    a, b, c, d = (island[:-1, :-1], island[:-1, 1:], island[1:, 1:], island[1:, :-1])
    whole = a & b & c & d
    used = np.zeros(island.shape, dtype=bool)
    for part in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]):
        used[part] |= whole
    number[used] = np.arange(int(used.sum()))
    corners = [number[:-1, :-1][whole], number[:-1, 1:][whole], number[1:, 1:][whole], number[1:, :-1][whole]]
    faces = np.concatenate((np.column_stack(corners[:3]), np.column_stack((corners[0], corners[2], corners[3]))))
    vertices = np.column_stack((sheet.xy[used], sheet.height[used]))
    sources = number[seed & used]
    distance = np.full(island.shape, np.nan)
    if len(sources):
        solver = potpourri3d.MeshHeatMethodDistanceSolver(vertices, faces)
        distance[used] = solver.compute_distance_multisource(sources.tolist())
    return distance


def longest_row(island: NDArray[np.bool_]) -> int:
    """The row with the longest run of good places; of several, the middle one."""
    longest = np.array([_run(row) for row in island])
    best = np.flatnonzero(longest >= longest.max() - 1)
    return int(best[len(best) // 2])


def _run(row: NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], row.astype(np.int8), [0]))))
    return int((edges[1::2] - edges[::2]).max(initial=0))
