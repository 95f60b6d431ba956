"""The mould from above, coloured by what was taken off it, and the histogram of that removal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from burnish.analysis.plot import CLASS_COLOURS, CLASS_NAMES, classes, new_figure, share_lines, vertex_areas
from burnish.analysis.raster import NOTHING, barycentric, rasterise
from burnish.core import Array, read_only
from burnish.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

MAP_PIXELS = 560
"""Pixels along the longer side of a map."""
REMOVAL_MAP = "viridis"
BINS = 48


@dataclass(frozen=True, kw_only=True)
class RemovalField:
    """What a run took off a mould; the mesh is seen along −z."""

    vertices: Array
    """Points [m], (V, 3)."""
    faces: NDArray[np.int64]
    """Triangles, (F, 3)."""
    removal: Array
    """Depth that was taken off at each vertex [m], (V,)."""
    evaluated: NDArray[np.bool_]
    """Vertices that count: those not in the declared edge band, (V,)."""
    target: float
    """Depth that was wanted [m]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", read_only(np.reshape(self.vertices, (-1, 3))))
        object.__setattr__(self, "faces", np.asarray(self.faces, dtype=np.int64).reshape(-1, 3))
        object.__setattr__(self, "removal", read_only(self.removal))
        object.__setattr__(self, "evaluated", np.asarray(self.evaluated, dtype=bool))
        points = (len(self.vertices),)
        if self.removal.shape != points or self.evaluated.shape != points:
            raise InputError(
                f"RemovalField: removal {self.removal.shape} and evaluated {self.evaluated.shape}; expected {points}"
            )
        if not self.target > 0.0 or not len(self.faces):
            raise InputError("RemovalField: expected a positive target and at least one face")

    @cached_property
    def view(self) -> TopView:
        """The mesh as pixels."""
        return TopView.of(self.vertices, self.faces)


@dataclass(frozen=True, kw_only=True)
class TopView:
    """Which vertices, with which weights, make each pixel of the view along −z; row 0 has the smallest y."""

    vertices: NDArray[np.int64]
    """Corners of the face seen by each covered pixel, (N, 3)."""
    weights: Array
    """Their shares, (N, 3)."""
    covered: NDArray[np.bool_]
    """Pixels that see the mesh, (H, W)."""
    extent_mm: tuple[float, float, float, float]
    """Left, right, bottom and top of the view [mm]."""

    @classmethod
    def of(cls, vertices: Array, faces: NDArray[np.int64]) -> TopView:
        """The view of a whole mesh."""
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        scale = MAP_PIXELS / float(np.max(high - low))
        width, height = np.maximum(np.ceil((high - low) * scale), 1).astype(int).tolist()
        corners = ((vertices[:, :2] - low) * scale)[faces]
        face = rasterise(corners, vertices[:, 2][faces], width, height).face
        covered = face != NOTHING
        row, column = np.nonzero(covered)
        seen = face[covered]
        weights = barycentric(corners[seen], np.stack([column + 0.5, row + 0.5], axis=1))
        reach = low + np.array([width, height]) / scale
        extent = (1e3 * low[0], 1e3 * reach[0], 1e3 * low[1], 1e3 * reach[1])
        return cls(vertices=faces[seen], weights=weights, covered=covered, extent_mm=extent)

    def image(self, values: Array) -> Array:
        """Values at the vertices, (V,), as an image (H, W); NaN beside the mesh."""
        picture = np.full(self.covered.shape, np.nan)
        picture[self.covered] = np.einsum("nc,nc->n", self.weights, np.asarray(values, dtype=np.float64)[self.vertices])
        return picture


def removal_map(field: RemovalField) -> Figure:
    """The mould from above by removal depth, the evaluated area outlined."""
    figure, axes = _canvas(field, "Removal")
    image = 1e6 * field.view.image(field.removal)
    top = max(1.6e6 * field.target, float(np.nanpercentile(image, 99.0)))
    shown = _show(axes, field, image, REMOVAL_MAP, (0.0, top))
    _outline(axes, field)
    bar = figure.colorbar(shown, ax=axes, extend="max", location="bottom", aspect=28)
    bar.set_label(f"removal [µm]\n(target {1e6 * field.target:.3g} µm)")
    for factor in (0.5, 1.0, 1.5):
        bar.ax.axvline(factor * 1e6 * field.target, color="white", linewidth=1.6 if factor == 1.0 else 0.8)
    return figure


def coverage_map(field: RemovalField) -> Figure:
    """The mould from above by class: too little, right, too much, not evaluated."""
    from matplotlib.colors import ListedColormap

    figure, axes = _canvas(field, "Coverage")
    inside = np.nan_to_num(field.view.image(field.evaluated.astype(float))) >= 0.5
    image = classes(np.nan_to_num(field.view.image(field.removal)), inside, field.target).astype(float)
    image[~field.view.covered] = np.nan
    shown = _show(axes, field, image, ListedColormap(CLASS_COLOURS), (-0.5, 3.5))
    bar = figure.colorbar(shown, ax=axes, ticks=range(4), location="bottom", aspect=28)
    bar.ax.set_xticklabels(_class_labels(field))
    bar.ax.tick_params(length=0)
    bar.set_label("removal, share of the evaluated area")
    return figure


def removal_histogram(field: RemovalField) -> Figure:
    """Share of the evaluated area over removal depth, with the borders of the classes."""
    figure = new_figure(height=2.8)
    axes = figure.subplots()
    target_um = 1e6 * field.target
    values, area = 1e6 * field.removal[field.evaluated], vertex_areas(field.vertices, field.faces)[field.evaluated]
    top = max(2.0 * target_um, float(np.percentile(values, 99.9)) if values.size else 0.0)
    share, edges = np.histogram(np.minimum(values, top), BINS, (0.0, top), weights=area)
    middle = 0.5 * (edges[1:] + edges[:-1])
    colour = [CLASS_COLOURS[k] for k in classes(middle, np.ones(BINS, dtype=bool), target_um)]
    # The pale colour of "right" is too faint for bars on white paper.
    colour = ["#8fa37e" if c == CLASS_COLOURS[1] else c for c in colour]
    axes.bar(middle, 100.0 * share / max(float(area.sum()), 1e-12), width=0.92 * float(edges[1]), color=colour)
    share_lines(axes, target_um)
    axes.set_xlim(0.0, top)
    axes.set_xlabel("removal [µm]")
    axes.set_ylabel("share of the evaluated area [%]")
    return figure


def removal_colours(field: RemovalField) -> Array:
    """Colour (sRGB) of each vertex by removal, (V, 3), on the scale of ``removal_map``, for a scene."""
    from matplotlib import colormaps

    top = max(1.6 * field.target, float(np.percentile(field.removal, 99.0)))
    return np.asarray(colormaps[REMOVAL_MAP](field.removal / top)[:, :3], dtype=np.float64)


def _canvas(field: RemovalField, title: str) -> tuple[Figure, Axes]:
    """An empty map, as high as the mould needs."""
    left, right, bottom, top = field.view.extent_mm
    figure = new_figure(height=4.1 * min((top - bottom) / (right - left), 2.0) + 1.5, width=5.0)
    axes = figure.subplots()
    axes.set_title(title, loc="left")
    return figure, axes


def _class_labels(field: RemovalField) -> list[str]:
    """Names of the classes with their share of the evaluated area."""
    area = vertex_areas(field.vertices, field.faces)
    members = np.bincount(classes(field.removal, field.evaluated, field.target), area, 4)
    total = max(float(members[:3].sum()), 1e-12)
    shares = [f"{CLASS_NAMES[k]}\n{100.0 * members[k] / total:.1f} %" for k in range(3)]
    return [*shares, CLASS_NAMES[3]]


def _show(
    axes: Axes, field: RemovalField, image: Array, colours: str | Colormap, limits: tuple[float, float]
) -> AxesImage:
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
    return axes.imshow(
        image, colours, origin="lower", extent=field.view.extent_mm, interpolation="nearest",
        vmin=limits[0], vmax=limits[1],
    )  # fmt: skip


def _outline(axes: Axes, field: RemovalField) -> None:
    inside = np.nan_to_num(field.view.image(field.evaluated.astype(float)))
    if inside.min() < 0.5 <= inside.max():
        axes.contour(inside, [0.5], extent=field.view.extent_mm, colors="white", linewidths=0.9, linestyles="--")
