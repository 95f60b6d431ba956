import numpy as np
import pytest
import trimesh

from burnish.gui.glb import Glb

BOX = trimesh.creation.box([0.1, 0.2, 0.3])


def read(data: bytes) -> trimesh.Trimesh:
    (mesh,) = trimesh.load(trimesh.util.wrap_as_stream(data), file_type="glb", process=False).geometry.values()
    return mesh


@pytest.fixture
def glb() -> Glb:
    return Glb(np.asarray(BOX.vertices), np.asarray(BOX.vertex_normals), np.asarray(BOX.faces))


def test_another_reader_finds_the_mesh(glb: Glb) -> None:
    found = read(glb.data)
    assert np.allclose(found.vertices, BOX.vertices, atol=1e-7)
    assert (found.faces == BOX.faces).all()


def test_another_reader_finds_the_colours_that_were_painted(glb: Glb) -> None:
    colours = np.arange(4 * len(BOX.vertices), dtype=np.uint8).reshape(-1, 4)
    assert (read(glb.paint(colours)).visual.vertex_attributes["color"] == colours).all()


def test_painting_changes_nothing_but_colours(glb: Glb) -> None:
    before = glb.data
    after = glb.paint(np.zeros((len(BOX.vertices), 4), dtype=np.uint8))
    assert len(before) == len(after)
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 4 * len(BOX.vertices)


def test_many_vertices_have_long_indices() -> None:
    vertices = np.random.default_rng(0).normal(size=(70_000, 3))
    faces = np.array([[0, 1, 69_999]])
    found = read(Glb(vertices, vertices, faces).data)
    assert (found.faces == faces).all()
