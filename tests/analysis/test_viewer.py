from __future__ import annotations

import json
import re
import zlib

import numpy as np
import pytest

from burnish.analysis import Camera, Shape, tube
from burnish.analysis.viewer import VERTEX, pack, viewer_html


@pytest.fixture
def shapes(ball):
    path = tube([[0, 0, 0], [0.5, 0, 0], [0.5, 0.4, 0]], 0.002, (0.1, 0.5, 0.9), "path")
    return [ball(name="arm"), path, ball(0.03, (0.3, 0.3, 0.3), name="arm", gloss=0.5)]


def unpack(packed):
    """The corners as a viewer sees them: positions, normals, colours, (3 F, 3) each."""
    data = zlib.decompress(packed.data)
    size = packed.header["vertices"] * VERTEX.itemsize
    corners = np.frombuffer(data[:size], VERTEX)[np.frombuffer(data[size:], "<u4")]
    low, extent = (np.array(packed.header[name]) for name in ("low", "size"))
    position = low + extent * corners["position"][:, :3] / 65535.0
    return position, corners["normal"][:, :3] / 127.0, corners["colour"] / 255.0


def test_packing_keeps_positions_normals_and_colours(shapes):
    packed = pack(shapes)
    # Groups of one name stand together: both arms, then the path.
    order = [shapes[0], shapes[2], shapes[1]]
    position, normal, colour = unpack(packed)
    true = np.concatenate([s.corners.reshape(-1, 3) for s in order])
    # Half a step of 1/65535 of the box.
    assert np.abs(position - true).max() <= 0.51 * max(packed.header["size"]) / 65535.0
    assert np.abs(normal - np.concatenate([s.corner_normals.reshape(-1, 3) for s in order])).max() < 0.5 / 127 + 1e-9
    assert np.abs(colour[:, :3] - np.concatenate([s.corner_colours.reshape(-1, 3) for s in order])).max() < 0.002
    assert set(np.round(colour[:, 3], 2)) == {0.0, 0.1, 0.5}


def test_groups_cover_all_corners_once(shapes):
    groups = pack(shapes).header["groups"]
    assert [g["name"] for g in groups] == ["arm", "path"]
    assert groups[0]["start"] == 0
    assert groups[1]["start"] == groups[0]["count"]
    assert sum(g["count"] for g in groups) == 3 * sum(len(s.faces) for s in shapes)


def test_shared_corners_are_stored_once(ball):
    smooth = ball(fineness=3)
    assert pack([smooth]).header["vertices"] == len(smooth.vertices)


def test_a_flat_scene_is_packed_without_dividing_by_zero():
    flat = Shape(name="f", vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), faces=[[0, 1, 2]], colour=np.ones(3))
    position, _, _ = unpack(pack([flat]))
    assert np.allclose(position, flat.vertices, atol=1e-5)


def test_a_hostile_name_cannot_end_the_script(ball):
    page = viewer_html(
        pack([ball(name="</script><img src=x onerror=alert(1)>")]), Camera(eye=(1, 0, 0), target=(0, 0, 0))
    )
    assert "<img" not in page
    header = re.search(r'<script type="application/json">(.*?)</script>', page).group(1)
    assert json.loads(header)["groups"][0]["name"].startswith("</script>")
