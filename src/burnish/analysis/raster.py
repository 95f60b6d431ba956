"""Triangles to pixels with numpy alone: which face is seen where.

Screen coordinates are pixels, x to the right, y downwards; the centre of pixel (row i, column j) is
(j + ½, i + ½). ``nearness`` is any quantity that is affine on the screen and grows towards the eye: the
reciprocal of the depth in a perspective view, the negative depth in an orthographic one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array

Index = NDArray[np.int64]

NOTHING = -1
"""The face of a pixel on which no triangle lies."""
FRAGMENTS_AT_ONCE = 2_000_000
"""Size of the bounding boxes that are worked on together: about 200 MB of temporary arrays at most."""
EDGE_TOLERANCE = 1e-7
"""Widening of each span [px], so that rounding opens no crack between two triangles that share an edge."""


@dataclass(frozen=True, kw_only=True)
class Raster:
    """What a picture shows, before any colour."""

    face: Index
    """Index of the nearest face of each pixel, (H, W); ``NOTHING`` where there is none."""
    nearness: Array
    """Nearness of that face, (H, W); −inf where there is none."""


def rasterise(corners: Array, nearness: Array, width: int, height: int) -> Raster:
    """The nearest triangle of every pixel.

    Each triangle is cut into horizontal spans, each span into pixels, both as whole arrays; the nearest
    pixel wins by an unbuffered maximum. Faces that do not have three finite corners are left out.

    Args:
        corners: screen positions of the corners [px], (F, 3, 2).
        nearness: nearness of the corners, (F, 3).
        width: columns of the picture.
        height: rows of the picture.
    """
    face = np.full(width * height, NOTHING, dtype=np.int64)
    best = np.full(width * height, -np.inf)
    for group in _groups(corners, nearness, width, height):
        pixel, owner, near = _fragments(corners[group], nearness[group], width, height)
        np.maximum.at(best, pixel, near)
        wins = near == best[pixel]
        face[pixel[wins]] = group[owner[wins]]
    return Raster(face=face.reshape(height, width), nearness=best.reshape(height, width))


def barycentric(corners: Array, points: Array) -> Array:
    """Weights of the three corners at screen points inside their triangles.

    Args:
        corners: one triangle a point [px], (N, 3, 2).
        points: the points [px], (N, 2).

    Returns:
        (N, 3), rows that sum to one.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    second = _cross(points - a, c - a) / area
    third = _cross(b - a, points - a) / area
    return np.stack([1.0 - second - third, second, third], axis=1)


def _cross(u: Array, v: Array) -> Array:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _groups(corners: Array, nearness: Array, width: int, height: int) -> Iterator[Index]:
    """Drawable faces in groups whose bounding boxes together stay near ``FRAGMENTS_AT_ONCE`` pixels."""
    finite = np.isfinite(corners).all(axis=(1, 2)) & np.isfinite(nearness).all(axis=1)
    faces = np.flatnonzero(finite)
    low, high = corners[faces].min(axis=1), corners[faces].max(axis=1)
    flat = np.abs(_cross(*(corners[faces, i] - corners[faces, 0] for i in (1, 2)))) < 1e-12
    outside = (high < 0.0).any(axis=1) | (low > (width, height)).any(axis=1)
    drawn = ~(flat | outside)
    box = np.clip(high, 0, (width, height)) - np.clip(low, 0, (width, height)) + 1.0
    work = np.cumsum(np.prod(box, axis=1)[drawn])
    faces = faces[drawn]
    if len(faces):
        yield from np.split(faces, np.flatnonzero(np.diff(work // FRAGMENTS_AT_ONCE)) + 1)


def _fragments(corners: Array, nearness: Array, width: int, height: int) -> tuple[Index, Index, Array]:
    """Flat pixel index, face and nearness of every pixel centre inside every triangle."""
    low, high = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    first = np.maximum(np.ceil(low - 0.5), 0.0).astype(np.int64)
    last = np.minimum(np.floor(high - 0.5), height - 1.0).astype(np.int64)
    owner, row = _expand(first, last)
    left, right = _spans(corners, owner, np.asarray(row + 0.5, dtype=np.float64))
    start = np.clip(np.ceil(left - 0.5 - EDGE_TOLERANCE), 0, width).astype(np.int64)
    stop = np.clip(np.floor(right - 0.5 + EDGE_TOLERANCE), -1, width - 1).astype(np.int64)
    span, column = _expand(start, stop)

    origin, along, down = _plane(corners, nearness)
    face = owner[span]
    near = (origin[owner] + down[owner] * (row + 0.5) + along[owner] * 0.5)[span] + along[face] * column
    # The plane of a sliver is steep: without the bound a rounding error could lift it before its neighbours.
    near = np.clip(near, nearness.min(axis=1)[face], nearness.max(axis=1)[face])
    return row[span] * width + column, face, near


def _expand(first: Index, last: Index) -> tuple[Index, Index]:
    """All whole numbers of the ranges first…last: (index of the range, number)."""
    count = np.maximum(last - first + 1, 0)
    owner = np.repeat(np.arange(len(first)), count)
    ordinal = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    return owner, first[owner] + ordinal


def _spans(corners: Array, owner: Index, y: Array) -> tuple[Array, Array]:
    """Left and right end of each triangle on horizontal lines [px]: the cut of three half planes."""
    turn = np.sign(_cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    left, right = np.full(len(y), -np.inf), np.full(len(y), np.inf)
    for i in range(3):
        p, q = corners[:, i], corners[:, (i + 1) % 3]
        dx, dy = (turn * (q[:, 0] - p[:, 0]))[owner], (turn * (q[:, 1] - p[:, 1]))[owner]
        # Inside where dx (y − p_y) − dy (x − p_x) ≥ 0.
        offset = dx * (y - p[owner, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = p[owner, 0] + offset / dy
        right = np.where(dy > 0.0, np.minimum(right, crossing), right)
        left = np.where(dy < 0.0, np.maximum(left, crossing), left)
        right = np.where((dy == 0.0) & (offset < 0.0), -np.inf, right)
    return left, right


def _plane(corners: Array, nearness: Array) -> tuple[Array, Array, Array]:
    """Nearness on the screen as origin + along·x + down·y, one plane a face."""
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    du, dv = nearness[:, 1] - nearness[:, 0], nearness[:, 2] - nearness[:, 0]
    area = _cross(u, v)
    along = (du * v[:, 1] - dv * u[:, 1]) / area
    down = (dv * u[:, 0] - du * v[:, 0]) / area
    return nearness[:, 0] - along * a[:, 0] - down * a[:, 1], along, down
