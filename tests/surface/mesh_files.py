"""Files of triangles in every form, written in the plainest way."""

from __future__ import annotations

import io
import struct
import zipfile

import numpy as np

from burnish.core import Array

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def shared(corners: Array) -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and faces, by another route than the package's."""
    vertices, number = np.unique(np.asarray(corners).reshape(-1, 3), axis=0, return_inverse=True)
    return vertices.tolist(), number.reshape(-1, 3).tolist()


def obj(corners: Array) -> bytes:
    vertices, faces = shared(corners)
    lines = ["# a part", "mtllib ../../etc/passwd", "o part", *("v {} {} {}".format(*v) for v in vertices), "vn 0 0 1"]
    lines += [f"f {a + 1}//1 {b + 1}/1/1 {c + 1}" for a, b, c in faces]
    return "\n".join([*lines, ""]).encode()


def ply_head(form: str, vertices: int, faces: int) -> bytes:
    return (
        f"ply\nformat {form} 1.0\ncomment made by a test\nelement vertex {vertices}\nproperty double x\n"
        f"property double y\nproperty double z\nproperty uchar red\nelement face {faces}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()


def ply(corners: Array, form: str = "ascii") -> bytes:
    vertices, faces = shared(corners)
    head = ply_head(form, len(vertices), len(faces))
    if form == "ascii":
        lines = ["{} {} {} 255".format(*v) for v in vertices] + ["3 {} {} {}".format(*f) for f in faces]
        return head + "\n".join([*lines, ""]).encode()
    order = "<" if form == "binary_little_endian" else ">"
    return (
        head
        + b"".join(struct.pack(f"{order}3dB", *v, 255) for v in vertices)
        + b"".join(struct.pack(f"{order}B3i", 3, *f) for f in faces)
    )


def model(corners: Array, unit: str = "millimeter", build: str = '<item objectid="1"/>', more: str = "") -> str:
    vertices, faces = shared(corners)
    nodes = "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*v) for v in vertices)
    triangles = "".join('<triangle v1="{}" v2="{}" v3="{}"/>'.format(*f) for f in faces)
    return (
        f'<?xml version="1.0"?>\n<model unit="{unit}" xmlns="{CORE}"><resources><object id="1" type="model"><mesh>'
        f"<vertices>{nodes}</vertices><triangles>{triangles}</triangles></mesh></object>{more}</resources>"
        f"<build>{build}</build></model>"
    )


def zipped(text: str | bytes, name: str = "3D/3dmodel.model", **others: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        for other, content in others.items():
            archive.writestr(f"3D/Objects/{other}.model", content)
        archive.writestr(name, text)
    return packed.getvalue()


def threemf(corners: Array) -> bytes:
    return zipped(model(corners))
