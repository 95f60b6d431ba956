from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from burnish.analysis.render import BACKDROP_BOTTOM, BACKDROP_TOP, Camera, Triangles, key_direction, png, render
from burnish.analysis.scene import Scene
from burnish.errors import InputError


def triangles(*shapes):
    return Triangles(
        corners=np.concatenate([s.corners for s in shapes]),
        normals=np.concatenate([s.corner_normals for s in shapes]),
        colours=np.concatenate([s.corner_colours for s in shapes]),
        gloss=np.concatenate([np.full(len(s.faces), s.gloss) for s in shapes]),
    )


def is_red(image):
    return (image[..., 0] > 60) & (image[..., 1] < 40)


def test_the_outline_of_a_ball_is_the_circle_of_its_tangent_cone(ball):
    camera = Camera(eye=(0.0, -1.0, 0.0), target=(0.0, 0.0, 0.0), field_of_view_deg=30.0)
    image = render(triangles(ball(radius=0.1, colour=(0.8, 0.0, 0.0), fineness=4)), camera, 200, 200)
    # Tangent cone of a sphere: sin α = r/d; the picture has 100/tan 15° pixels to tan α = 1.
    radius = 100.0 / np.tan(np.radians(15.0)) * np.tan(np.arcsin(0.1))
    seen = is_red(image).sum()
    # Half a pixel along the rim, and an icosphere of this fineness is 0.1 % flat.
    assert seen == pytest.approx(np.pi * radius**2, abs=2.0 * np.pi * radius * 0.6)
    rows, columns = np.nonzero(is_red(image))
    assert (rows.mean(), columns.mean()) == pytest.approx((99.5, 99.5), abs=0.3)


def test_project_is_the_inverse_of_rays(rng):
    camera = Camera(eye=(0.3, -1.0, 0.7), target=(0.0, 0.1, 0.2))
    x, y = rng.uniform(0.0, 640.0, 50), rng.uniform(0.0, 400.0, 50)
    depth = rng.uniform(0.2, 3.0, 50)
    place, nearness = camera.project(camera.eye + depth[:, None] * camera.rays(x, y, 640, 400), 640, 400)
    assert np.allclose(place, np.stack([x, y], 1), atol=1e-9)
    assert np.allclose(nearness, 1.0 / depth, rtol=1e-12)


def test_what_is_behind_the_eye_is_not_projected():
    place, nearness = Camera(eye=(0, -1, 0), target=(0, 0, 0)).project(np.array([[0.0, -2.0, 0.0]]), 64, 64)
    assert np.isnan(place).all()
    assert np.isnan(nearness).all()


def test_a_near_ball_hides_a_far_one(ball):
    near, far = ball(0.1, (0, -0.5, 0), (0.9, 0, 0)), ball(0.1, (0, 0.5, 0), (0, 0, 0.9))
    camera = Camera(eye=(0.0, -2.0, 0.0), target=(0.0, 0.0, 0.0))
    for heap in (triangles(near, far), triangles(far, near)):
        assert is_red(render(heap, camera, 60, 60)[28:32, 28:32]).all()


def test_up_is_up_and_right_is_right(ball):
    camera = Camera(eye=(0.0, -2.0, 0.0), target=(0.0, 0.0, 0.0))
    image = render(triangles(ball(0.05, (0.3, 0.0, 0.3), (0.9, 0, 0))), camera, 100, 100)
    rows, columns = np.nonzero(is_red(image))
    assert rows.max() < 50 < columns.min()


def test_the_side_towards_the_key_light_is_brighter(ball):
    camera = Camera(eye=(0.0, -1.0, 0.0), target=(0.0, 0.0, 0.0))
    shape = ball(0.2)
    image = render(triangles(shape), camera, 120, 120).astype(float)
    towards = camera.project(0.17 * key_direction(camera)[None], 120, 120)[0][0].astype(int)
    away = 119 - towards
    assert image[towards[1], towards[0]].mean() > 1.5 * image[away[1], away[0]].mean()


def test_a_surface_looks_the_same_from_both_sides(ball):
    camera = Camera(eye=(0.0, -1.0, 0.0), target=(0.0, 0.0, 0.0))
    heap = triangles(ball(0.1))
    turned = Triangles(corners=heap.corners, normals=-heap.normals, colours=heap.colours, gloss=heap.gloss)
    difference = render(heap, camera, 60, 60).astype(int) - render(turned, camera, 60, 60)
    # The rim, where interpolated normals just turn away, may differ; the disc may not.
    assert np.mean(np.abs(difference) > 2) < 0.02


def test_a_body_between_light_and_surface_throws_a_shadow_on_it(ball):
    camera = Camera(eye=(0.0, -1.0, 2.0), target=(0.0, 0.0, 0.0))
    big = ball(0.3, (0.0, 0.0, 0.0), (0.7, 0.7, 0.7), fineness=4)
    spot = 0.3 * key_direction(camera)
    small = ball(0.05, tuple(1.6 * spot), (0.7, 0.7, 0.7))
    column, row = camera.project(spot[None], 200, 200)[0][0].astype(int)
    free, shaded = (render(triangles(*shapes), camera, 200, 200) for shapes in ((big,), (big, small)))
    # The small ball is far enough towards the light to stand beside the spot in the picture.
    assert shaded[row, column].astype(int).max() < 0.85 * free[row, column].min()


def test_the_floor_is_darker_under_a_body_and_the_sky_is_not(ball):
    camera = Camera.framing(ball(0.1).vertices, (0.0, -1.0, 0.7))
    image = render(triangles(ball(0.1)), camera, 160, 100).astype(float)
    empty = np.linspace(0.0, 1.0, 100)[:, None] ** 1.3
    backdrop = 255.0 * ((1 - empty) * np.power(BACKDROP_TOP, 2.2) + empty * np.power(BACKDROP_BOTTOM, 2.2)) ** (1 / 2.2)
    assert np.allclose(image[:3], backdrop[:3, None], atol=1.0)
    assert (image[60:, :].min(axis=2) < 0.8 * backdrop[60:].min(axis=1)[:, None]).any()


def test_framing_sees_all_points_and_touches_the_frame(rng):
    points = rng.normal(size=(200, 3)) * (1.0, 0.3, 0.5)
    for direction in rng.normal(size=(20, 3)):
        camera = Camera.framing(points, direction, aspect=1.6, margin=1.0)
        place, _ = camera.project(points, 160, 100)
        offset = np.abs(place - (80.0, 50.0)) / (80.0, 50.0)
        assert offset.max() == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    "wrong",
    [
        {"eye": (0, 0, 0), "target": (0, 0, 0)},
        {"eye": (0, 0, 1), "target": (0, 0, 0)},
        {"eye": (0, 1, 0), "target": (0, 0, 0), "field_of_view_deg": 0.0},
    ],
)
def test_a_camera_that_cannot_see_is_refused(wrong):
    with pytest.raises(InputError):
        Camera(**wrong)


def test_a_still_is_a_png_of_the_wanted_size(ball):
    data = Scene.of([ball()]).still(64, 40)
    with Image.open(io.BytesIO(data)) as image:
        assert (image.format, image.size, image.mode) == ("PNG", (64, 40), "RGB")


def test_png_keeps_every_pixel(rng):
    image = rng.integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png(image)))), image)
