from pathlib import Path

import numpy as np
import pytest
import viser

from burnish.gui.part import Part
from burnish.gui.scene import REFUSED, Scene
from burnish.model.looks import looks
from burnish.model.model import Model
from burnish.model.tool import PolishingTool
from burnish.paths.stroke import Stroke
from burnish.polish.cell import HOME, READY
from burnish.rotation import from_quaternion


@pytest.fixture(scope="module")
def server():
    found = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield found
    found.stop()


@pytest.fixture
def scene(server) -> Scene:
    server.scene.reset()
    return Scene(server.scene)


@pytest.fixture(scope="module")
def part() -> Part:
    return Part.bundled("plate")


def put(scene: Scene, part: Part) -> None:
    scene.put(part.mould, part.canvas, PolishingTool())


def test_the_arm_stands_where_its_model_says(scene: Scene) -> None:
    for q in (HOME, READY):
        scene.move(q)
        for link, pose in Model.jaco2().link_poses(q).items():
            if link in scene._links:
                assert scene._links[link].position == pytest.approx(pose[:3, 3])
                assert from_quaternion(np.asarray(scene._links[link].wxyz)) == pytest.approx(pose[:3, :3], abs=1e-9)


def test_every_link_of_the_description_that_has_a_shape_is_drawn(scene: Scene) -> None:
    assert {look.link for look in looks()} <= set(scene._links)


def test_paint_reaches_the_browser_as_a_file_of_the_same_length(scene: Scene, part: Part) -> None:
    put(scene, part)
    before = scene._glb.glb_data
    scene.paint.depth[:] = scene.paint.target
    scene.repaint()
    assert scene._glb.glb_data != before
    assert len(scene._glb.glb_data) == len(before)


def test_another_part_takes_the_place_of_the_first_and_of_its_paint(scene: Scene, part: Part) -> None:
    put(scene, part)
    scene.paint.depth[:] = 1.0
    put(scene, part)
    assert not scene.paint.depth.any()
    scene.clear()
    assert scene.paint is None


def test_a_refused_plan_is_marked_where_it_is_refused(scene: Scene, part: Part) -> None:
    put(scene, part)
    x = np.linspace(0.0, 0.05, 11)
    points = np.column_stack([x, 0.0 * x, 0.02 + 0.0 * x])
    stroke = Stroke(
        points=points, normals=np.tile([0.0, 0.0, 1.0], (11, 1)), feed=np.full(11, 0.02), force=np.full(11, 10.0)
    )
    scene.plan([stroke], points[5], "too fast")
    mark = next(handle for handle in scene._strokes if handle.name.endswith("refused"))
    assert mark.position == pytest.approx(points[5])
    assert tuple(mark.color) == REFUSED
    scene.plan(())
    assert scene._strokes == []


def test_a_part_of_the_library_is_worked_by_its_own_name(tmp_path: Path) -> None:
    from gui_bench import block

    from burnish.library import Library

    with Library.open(tmp_path / "library") as library:
        row = library.add_mould(block(tmp_path), unit="mm")
        found = Part.of_row(library, row)
        assert Path(found.source).is_relative_to(library.root)
        assert found.mould.name == "block"
        assert found.mould.sha256 == row.geometry
