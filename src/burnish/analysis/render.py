"""A picture of triangles by software: a camera, three lights and a shadow, where no graphics card is at hand.

Colours are sRGB in 0…1 at the border and linear inside. World z is up.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from burnish.analysis.raster import NOTHING, barycentric, rasterise
from burnish.analysis.shadow import Shadow
from burnish.core import Array, read_only
from burnish.errors import InputError

Image = NDArray[np.uint8]

GAMMA = 2.2
"""Exponent between sRGB and linear light; a picture for people, not a measurement."""
OVERSAMPLING = 2
"""Rays across a pixel in each direction."""
NEAR = 0.01
"""Faces with a corner closer to the eye than this, or behind it, are not drawn [m]."""
BACKDROP_TOP = (0.975, 0.980, 0.985)
BACKDROP_BOTTOM = (0.885, 0.895, 0.905)
"""Colours of the backdrop at the upper and lower edge of the picture, sRGB."""
KEY, FILL, SKY, EARTH = 2.05, 0.35, 0.52, 0.26
"""Strengths of the key light, of the fill light, and of the ambient light from above and from below."""
SHADOW_DEPTH = 0.42
"""Share of the floor's light that the key light's shadow takes away."""


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera."""

    eye: Array
    """Position of the pinhole [m], (3,)."""
    target: Array
    """Point in the middle of the picture [m], (3,)."""
    up: Array = field(default_factory=lambda: read_only((0.0, 0.0, 1.0)))
    """Direction that points upwards in the picture, (3,); not along the line of sight."""
    field_of_view_deg: float = 30.0
    """Angle between the lower and the upper edge [°]."""

    def __post_init__(self) -> None:
        for name in ("eye", "target", "up"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        if np.linalg.norm(np.cross(self.target - self.eye, self.up)) < 1e-9:
            raise InputError("Camera: the line of sight is zero or parallel to `up`; move the eye beside the target")
        if not 1.0 <= self.field_of_view_deg <= 150.0:
            raise InputError(f"Camera: field of view {self.field_of_view_deg}°; expected 1° to 150°")

    @classmethod
    def framing(cls, points: ArrayLike, direction: ArrayLike, aspect: float = 1.6, margin: float = 1.06) -> Camera:
        """The camera that looks along −``direction`` and just sees all ``points``.

        Args:
            points: what shall be seen [m], (N, 3).
            direction: from the scene towards the camera, any length, (3,).
            aspect: width of the picture over its height.
            margin: free space around the points, 1 for none.
        """
        cloud = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        back = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
        probe = cls(eye=back, target=np.zeros(3))
        axes = probe.axes
        middle = axes.T @ (0.5 * ((cloud @ axes.T).min(axis=0) + (cloud @ axes.T).max(axis=0)))
        seen = (cloud - middle) @ axes.T
        half = np.tan(np.radians(probe.field_of_view_deg) / 2.0) / margin
        distance = np.max(np.maximum(np.abs(seen[:, 0]) / aspect, np.abs(seen[:, 1])) / half - seen[:, 2])
        return cls(eye=middle + max(float(distance), 10.0 * NEAR) * back, target=middle)

    @property
    def axes(self) -> Array:
        """Rows: right, up and forward of the picture in world axes, (3, 3)."""
        forward = self.target - self.eye
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward])

    def project(self, points: Array, width: int, height: int) -> tuple[Array, Array]:
        """Pixel positions (…, 2) and nearness 1/depth (…,) of points (…, 3); NaN for those behind the eye."""
        seen = (points - self.eye) @ self.axes.T
        depth = np.where(seen[..., 2] > NEAR, seen[..., 2], np.nan)
        scale = 0.5 * height / np.tan(np.radians(self.field_of_view_deg) / 2.0)
        x = 0.5 * width + scale * seen[..., 0] / depth
        y = 0.5 * height - scale * seen[..., 1] / depth
        return np.stack([x, y], axis=-1), 1.0 / depth

    def rays(self, x: Array, y: Array, width: int, height: int) -> Array:
        """Directions (N, 3) of the lines of sight through pixel positions; unit length along the forward axis."""
        slope = 2.0 * np.tan(np.radians(self.field_of_view_deg) / 2.0) / height
        right, up, forward = self.axes
        across = np.multiply.outer((x - 0.5 * width) * slope, right)
        return np.asarray(forward + across + np.multiply.outer((0.5 * height - y) * slope, up))


@dataclass(frozen=True, kw_only=True)
class Triangles:
    """What is drawn: a heap of triangles that share nothing."""

    corners: Array
    """Positions [m], (F, 3, 3): face, corner, coordinate."""
    normals: Array
    """Unit normals at the corners, (F, 3, 3)."""
    colours: Array
    """sRGB at the corners in 0…1, (F, 3, 3)."""
    gloss: Array
    """Strength of the highlight, 0 (felt) to 1 (polished), (F,)."""


def render(triangles: Triangles, camera: Camera, width: int = 1280, height: int = 800) -> Image:
    """The picture (height, width, 3), sRGB, with the floor under the lowest corner."""
    w, h = OVERSAMPLING * width, OVERSAMPLING * height
    screen, nearness = camera.project(triangles.corners, w, h)
    face = rasterise(screen, nearness, w, h).face.ravel()
    key = key_direction(camera)
    shadow = Shadow.cast(triangles.corners, key)
    light = np.repeat(np.repeat(_backdrop(camera, shadow, width, height), OVERSAMPLING, 0), OVERSAMPLING, 1)
    light = light.reshape(-1, 3)
    pixel = np.flatnonzero(face != NOTHING)
    seen = face[pixel]
    points = np.stack([pixel % w + 0.5, pixel // w + 0.5], axis=1)
    weights = barycentric(screen[seen], points) * nearness[seen]
    weights = (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
    light[pixel] = _shade(triangles, seen, weights, camera, key, shadow)
    pooled = light.reshape(height, OVERSAMPLING, width, OVERSAMPLING, 3).mean(axis=(1, 3))
    return np.asarray(np.clip(pooled, 0.0, 1.0) ** (1.0 / GAMMA) * 255.0 + 0.5).astype(np.uint8)


def png(image: Image) -> bytes:
    """The picture as a PNG file."""
    from PIL import Image as Pillow  # Only pictures need it, and it is not free to load.

    buffer = io.BytesIO()
    Pillow.fromarray(image).save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


def key_direction(camera: Camera) -> Array:
    """Unit vector towards the key light: high, over the left shoulder of the camera."""
    right, _, forward = camera.axes
    towards = -0.75 * right - 0.45 * forward * (1.0, 1.0, 0.0) + np.array([0.0, 0.0, 1.15])
    return np.asarray(towards / np.linalg.norm(towards))


def _interpolate(values: Array, face: NDArray[np.int64], weights: NDArray[np.float32]) -> NDArray[np.float32]:
    corners = values.astype(np.float32)[face]
    return np.asarray(np.einsum("nc,ncd->nd", weights, corners))


def _shade(
    triangles: Triangles,
    face: NDArray[np.int64],
    weights: NDArray[np.float32],
    camera: Camera,
    key: Array,
    shadow: Shadow,
) -> NDArray[np.float32]:
    """Linear light of the seen points: ambient + shadowed key + fill + highlight (Blinn and Phong)."""
    position = _interpolate(triangles.corners, face, weights)
    normal = _interpolate(triangles.normals, face, weights)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + np.float32(1e-12)
    colour = _interpolate(triangles.colours**GAMMA, face, weights)
    gloss = triangles.gloss.astype(np.float32)[face]
    view = camera.eye.astype(np.float32) - position
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    # Open meshes are seen from both sides.
    normal *= np.where(np.einsum("nd,nd->n", normal, view) < 0.0, np.float32(-1.0), np.float32(1.0))[:, None]

    lit = np.maximum(normal @ key.astype(np.float32), 0.0) * shadow.lit(position + 0.003 * normal)
    fill = np.maximum(normal @ (-key * (1.0, 1.0, -0.3)).astype(np.float32), 0.0)
    ambient = EARTH + (SKY - EARTH) * (0.5 + 0.5 * normal[:, 2])
    half = view + key.astype(np.float32)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    cosine = np.maximum(np.einsum("nd,nd->n", normal, half), 0.0)
    rim = (1.0 - np.abs(np.einsum("nd,nd->n", normal, view))) ** 3
    highlight = gloss * (0.55 * cosine**48 * (lit > 0.0) + 0.16 * rim)
    return np.asarray(colour * (KEY / np.pi * 1.1 * lit + FILL * fill + ambient)[:, None] + highlight[:, None])


def _backdrop(camera: Camera, shadow: Shadow, width: int, height: int) -> NDArray[np.float32]:
    """Linear light of the backdrop, (height, width, 3), darker where the shadow falls on the floor."""
    top, bottom = (np.asarray(colour) ** GAMMA for colour in (BACKDROP_TOP, BACKDROP_BOTTOM))
    fade = np.linspace(0.0, 1.0, height)[:, None] ** 1.3
    light = np.repeat((top + fade * (bottom - top))[:, None, :], width, axis=1).astype(np.float32)
    # The shadow on the floor is soft: every second line of sight in each direction is enough.
    row, column = np.mgrid[0:height:2, 0:width:2].reshape(2, -1)
    rays = camera.rays(column + 1.0, row + 1.0, width, height)
    drop = (shadow.floor - camera.eye[2]) / np.where(rays[:, 2] < -1e-4, rays[:, 2], np.nan)
    hit = np.flatnonzero(drop > 0.0)
    shade = np.zeros(len(row), dtype=np.float32)
    shade[hit] = SHADOW_DEPTH * shadow.on_floor(camera.eye + drop[hit, None] * rays[hit])
    shade = shade.reshape((height + 1) // 2, -1).repeat(2, axis=0).repeat(2, axis=1)[:height, :width]
    return np.asarray(light * (1.0 - shade)[..., None])
