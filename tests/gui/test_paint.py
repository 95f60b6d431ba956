import numpy as np
import pytest

from burnish.finish.removal import Removal
from burnish.gui.paint import EXPOSURE, FULL, MOST, SHOWN, STEEL, Canvas, Paint, linear, merged, scale
from burnish.model.tool import PolishingTool
from burnish.polish.recipe import PRESTON
from burnish.surface import Mould


@pytest.fixture(scope="module")
def canvas() -> Canvas:
    return Canvas.of(Mould.load("plate"))


def line(canvas: Canvas) -> np.ndarray:
    x = np.linspace(-0.05, 0.05, 101)
    return np.column_stack([x, 0.0 * x, np.full(101, canvas.vertices[:, 2].max())])


def test_a_plate_of_nine_corners_becomes_fine_enough_to_be_painted(canvas: Canvas) -> None:
    assert 0.3 * SHOWN < len(canvas.vertices) < 3 * SHOWN


def test_the_removed_volume_is_prestons(canvas: Canvas) -> None:
    paint = Paint(canvas=canvas)
    paint.rub(line(canvas), np.full(101, 10.0), np.full(101, 1e-3))
    assert paint.depth @ canvas.surface.areas == pytest.approx(PRESTON * 10.0 * 0.101, rel=1e-9)


def test_depth_is_that_of_the_full_law_as_far_as_the_mesh_resolves_it(canvas: Canvas) -> None:
    paint, points = Paint(canvas=canvas), line(canvas)
    paint.rub(points, np.full(101, 10.0), np.full(101, 1e-3))
    tool = PolishingTool()
    law = Removal(coefficient=PRESTON, tip_radius=tool.tip_radius, modulus=tool.modulus)
    normals = np.tile([0.0, 0.0, 1.0], (101, 1))
    full = law.depth(
        canvas.surface, contacts=points, normals=normals, force=np.full(101, 10.0), speed=np.full(101, 0.02),
        dt=np.full(101, 0.05),
    )  # fmt: skip
    inside = np.abs(canvas.vertices[:, 0]) < 0.04
    # Both smear over about two spacings of the mesh, by different rules.
    assert paint.depth[inside].sum() == pytest.approx(full[inside].sum(), rel=0.05)


def test_nothing_is_removed_where_nothing_is_pressed(canvas: Canvas) -> None:
    paint = Paint(canvas=canvas)
    paint.rub(line(canvas), np.full(101, np.nan), np.full(101, 1e-3))
    paint.rub(line(canvas), np.full(101, -3.0), np.full(101, 1e-3))
    assert not paint.depth.any()


def test_a_contact_off_the_surface_removes_nothing(canvas: Canvas) -> None:
    paint = Paint(canvas=canvas)
    paint.rub(np.array([[0.0, 0.0, 0.5]]), np.array([10.0]), np.array([1e-3]))
    assert not paint.depth.any()


def test_shares_are_of_the_area(canvas: Canvas) -> None:
    paint = Paint(canvas=canvas, target=1.0)
    left = canvas.vertices[:, 0] < 0.0
    paint.depth[:] = np.where(left, 2.0, 0.6)
    covered, too_much = paint.shares()
    assert covered == pytest.approx(1.0)
    assert too_much == pytest.approx(canvas.surface.areas[left].sum() / canvas.surface.areas.sum())


def test_colours_run_from_steel_to_the_end_of_the_scale(canvas: Canvas) -> None:
    paint = Paint(canvas=canvas, target=1.0)
    paint.depth[0], paint.depth[1] = FULL, 100.0
    colours = paint.colours()
    assert np.allclose(colours[2, :3], np.rint(255.0 * EXPOSURE * linear(np.array(STEEL))), atol=1)
    assert (colours[0] == scale(EXPOSURE)[-1]).all()
    assert (colours[1] == scale(EXPOSURE)[-1]).all()


def test_light_is_that_of_the_standard() -> None:
    # IEC 61966-2-1: sRGB 0.5 is 0.2140 of the light.
    assert linear(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 0.21404, 1.0], abs=1e-5)


def test_a_mesh_too_fine_for_a_browser_is_merged_and_keeps_its_shape() -> None:
    n = 260
    x, y = np.meshgrid(np.linspace(0.0, 0.1, n), np.linspace(0.0, 0.1, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.stack([first, first + 1, first + n], 1), np.stack([first + 1, first + n + 1, first + n], 1)]
    )
    fewer, left = merged(vertices, faces, 0.01)
    assert len(vertices) > MOST > len(fewer)
    corners = fewer[left]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2.0
    assert area == pytest.approx(0.01, rel=0.03)
