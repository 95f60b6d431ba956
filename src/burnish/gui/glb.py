"""A mesh as a GLB file whose colours can be changed in place.

Sending a mesh anew for every change of its colours costs ten times as much as overwriting the bytes of COLOR_0 in the
file that the browser has. glTF 2.0: little-endian, colours linear, four bytes a vertex.
"""

from __future__ import annotations

import json
import struct

import numpy as np
from numpy.typing import NDArray

from burnish.core import Array
from burnish.surface.winding import Faces

MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
FLOAT, UNSIGNED_INT, UNSIGNED_SHORT, UNSIGNED_BYTE = 5126, 5125, 5123, 5121
VERTICES, INDICES = 34962, 34963
"""Words of the glTF 2.0 specification."""


class Glb:
    """A coloured mesh; ``data`` is the file."""

    def __init__(self, vertices: Array, normals: Array, faces: Faces, roughness: float = 0.55) -> None:
        """A white mesh.

        Args:
            vertices: [m], (V, 3).
            normals: outward unit normals, (V, 3).
            faces: (F, 3).
            roughness: of the material, 0 (mirror) to 1 (felt).
        """
        p, n = (np.ascontiguousarray(array, dtype="<f4") for array in (vertices, normals))
        colours = np.full((len(p), 4), 255, dtype=np.uint8)
        short = len(p) < 2**16
        indices = np.ascontiguousarray(faces, dtype="<u2" if short else "<u4")
        blocks = [p.tobytes(), n.tobytes(), colours.tobytes(), indices.tobytes()]
        blocks[3] += bytes(-len(blocks[3]) % 4)
        offsets = np.concatenate([[0], np.cumsum([len(block) for block in blocks])]).tolist()
        views = [
            {"buffer": 0, "byteOffset": offsets[i], "byteLength": len(blocks[i]), "target": target}
            for i, target in enumerate((VERTICES, VERTICES, VERTICES, INDICES))
        ]
        accessors = [
            _accessor(0, FLOAT, "VEC3", len(p)) | {"min": p.min(axis=0).tolist(), "max": p.max(axis=0).tolist()},
            _accessor(1, FLOAT, "VEC3", len(p)),
            _accessor(2, UNSIGNED_BYTE, "VEC4", len(p)) | {"normalized": True},
            _accessor(3, UNSIGNED_SHORT if short else UNSIGNED_INT, "SCALAR", indices.size),
        ]
        primitive = {"attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}, "indices": 3, "material": 0}
        surface = {"metallicFactor": 0.0, "roughnessFactor": roughness}
        head = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [primitive]}],
            "materials": [{"pbrMetallicRoughness": surface, "doubleSided": True}],
            "buffers": [{"byteLength": offsets[-1]}],
            "bufferViews": views,
            "accessors": accessors,
        }
        text = json.dumps(head, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        start = 12 + 8 + len(text) + 8
        self._data = bytearray(struct.pack("<III", MAGIC, VERSION, start + offsets[-1]))
        self._data += struct.pack("<II", len(text), JSON_CHUNK) + text
        self._data += struct.pack("<II", offsets[-1], BINARY_CHUNK) + b"".join(blocks)
        self._colours = np.frombuffer(self._data, dtype=np.uint8, count=4 * len(p), offset=start + offsets[2])
        self._colours = self._colours.reshape(len(p), 4)

    @property
    def data(self) -> bytes:
        """The file as it is now."""
        return bytes(self._data)

    def paint(self, colours: NDArray[np.uint8]) -> bytes:
        """The file with these colours, linear red, green, blue and alpha, (V, 4)."""
        self._colours[:] = colours
        return bytes(self._data)


def _accessor(view: int, component: int, kind: str, count: int) -> dict[str, object]:
    return {"bufferView": view, "componentType": component, "type": kind, "count": count}
