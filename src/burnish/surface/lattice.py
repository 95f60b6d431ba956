"""Distance to a surface at all nodes of a regular lattice, each found from its neighbours.

Looking up the nearest of all samples costs ten times as much as anything else. So only every fourth node
along each axis is looked up; the nodes between them start with the best sample of their neighbours, and
improve it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.surface.nearest import Nearest

STRIDE = 4
"""Nodes along each axis of which one is looked up; a power of two."""


def distances(nearest: Nearest, origin: Array, spacing: float, cells: NDArray[np.int64]) -> Array:
    """Unsigned distance [m] at the nodes origin + spacing · (ix, iy, iz), (nx, ny, nz).

    Args:
        nearest: the sampled surface.
        origin: first node [m], (3,).
        spacing: distance of the nodes [m].
        cells: STRIDEs along each axis, (3,); each axis has STRIDE · cells + 1 nodes.
    """
    stride = STRIDE
    lines = [origin[i] + spacing * stride * np.arange(cells[i] + 1) for i in range(3)]
    sample = nearest.sample(_nodes(lines)).reshape(cells + 1)
    while stride > 1:
        stride //= 2
        for axis in range(3):
            lines[axis] = origin[axis] + spacing * stride * np.arange(2 * sample.shape[axis] - 1)
            sample = _doubled(nearest.samples, sample, lines, axis)
        _exchange(nearest.samples, sample, lines)
        sample = nearest.climb(_nodes(lines), sample.ravel()).reshape(sample.shape)
    return nearest.distance(_nodes(lines), sample.ravel()).reshape(sample.shape)


def _doubled(samples: Array, sample: NDArray[np.int64], lines: list[Array], axis: int) -> NDArray[np.int64]:
    """Nearest samples with new nodes in the middle along one axis, which take the better of two neighbours."""
    one, other = sample[_along(axis, slice(None, -1))], sample[_along(axis, slice(1, None))]
    middle = [line[1::2] if i == axis else line for i, line in enumerate(lines)]
    better = _squared(samples, other, middle) < _squared(samples, one, middle)
    shape = tuple(len(line) for line in lines)
    doubled = np.empty(shape, dtype=np.int64)
    doubled[_along(axis, slice(None, None, 2))] = sample
    doubled[_along(axis, slice(1, None, 2))] = np.where(better, other, one)
    return doubled


def _exchange(samples: Array, sample: NDArray[np.int64], lines: list[Array]) -> None:
    """Let each node try the samples of its neighbours along each axis, in place."""
    squared = _squared(samples, sample, lines)
    for axis in range(3):
        lower, upper = _along(axis, slice(None, -1)), _along(axis, slice(1, None))
        for here, there in ((upper, lower), (lower, upper)):
            trial = _squared(samples, sample[there], [line[here[i]] for i, line in enumerate(lines)])
            better = trial < squared[here]
            sample[here] = np.where(better, sample[there], sample[here])
            squared[here] = np.where(better, trial, squared[here])


def _squared(samples: Array, sample: NDArray[np.int64], lines: Sequence[Array]) -> Array:
    """Squared distance of each node of a lattice to its sample [m²]."""
    x, y, z = np.meshgrid(*lines, indexing="ij", sparse=True)
    dx, dy, dz = samples[sample, 0] - x, samples[sample, 1] - y, samples[sample, 2] - z
    return np.asarray(dx * dx + dy * dy + dz * dz)


def _along(axis: int, part: slice) -> tuple[slice, slice, slice]:
    """Index of a part of a lattice along one axis, and of all along the others."""
    index = [slice(None)] * 3
    index[axis] = part
    return index[0], index[1], index[2]


def _nodes(lines: Sequence[Array]) -> Array:
    """All nodes of a lattice with these lines, (N, 3)."""
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
