"""Throw damaged files at everything that reads a file from outside; only refusals may come of it, and soon.

    python scripts/fuzz_inputs.py --count 100000 --seed 1

Recordings, meshes, limits, recipes, poses files, plans, journals, operators' sessions and robot descriptions are taken
whole and damaged: bits flipped, pieces cut out, doubled, moved or replaced by what hurts readers (NaN, huge numbers,
deep nesting, lengths that lie). Each has to be read, or refused with a `BurnishError`, within 2 s, and all of it within
1 GiB of memory.
"""

from __future__ import annotations

import argparse
import io
import json
import logging
import random
import resource
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from burnish.core import Dynamics, Sample, ToolReference
from burnish.errors import BurnishError
from burnish.model.description import check_description
from burnish.model.model import JACO2_URDF
from burnish.paths.patterns import CrossHatch, Polyline
from burnish.polish.journal import FORMAT
from burnish.polish.journal import read as read_journal
from burnish.polish.plan_file import read_plan
from burnish.polish.recipe import Pass, Recipe
from burnish.polish.recipe_file import as_toml, read_recipe
from burnish.record.mcap_file import McapFile
from burnish.record.mcap_scan import Content, messages, scan
from burnish.record.messages import SCHEMAS
from burnish.record.poses_file import read_poses
from burnish.record.recorder import TOPICS, Recorder
from burnish.record.recording import Recording
from burnish.record.recover import recover
from burnish.runtime.limits import Limits
from burnish.surface import Mould
from burnish.teleop.scripted import HEAD, read_script

LONGEST = 2.0
"""Time that one input may take [s]."""
MOST = 2**30
"""Memory that the process may have taken in the end [B]."""
HURTS = [
    b"NaN", b"-Infinity", b"1e999", b"1" * 400, b"[" * 2000, b"{\"a\":" * 500, b"\xff\xff\xff\xff", b"\x00" * 8,
    b"\xff" * 8, b"../../x", b"\x89MCAP0\r\n", b"\x04\x00\x00\x00zstd", b"\x00", b"-0.0", b"\xc3\x28", b"1e-400",
    b"\x06\x00\x00\x00\x00\x00\x00\x00\x7f", b"inf", b"0x1p3", b"\n", b"&lol;", b"<!DOCTYPE x [", b"</link>",
    b"endfacet",
]  # fmt: skip
"""Pieces that readers have tripped over."""


def damaged(data: bytes, rng: random.Random) -> bytes:
    """The bytes with one to four things wrong with them."""
    found = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        kind = rng.randrange(7)
        at = rng.randrange(len(found) + 1)
        end = min(len(found), at + rng.choice((1, 4, 8, 40, 1000)))
        if kind == 0 and at < len(found):
            found[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del found[at:]
        elif kind == 2:
            del found[at:end]
        elif kind == 3:
            found[at:at] = found[at:end] * rng.choice((1, 2, 50))
        elif kind == 4:
            found[at:end] = rng.choice(HURTS)
        elif kind == 5:
            found[at:at] = rng.choice(HURTS)
        else:
            found[at:end] = rng.randbytes(end - at)
    return bytes(found)


def a_recording(path: Path) -> bytes:
    """A small recording."""
    rng = np.random.default_rng(0)
    eye = np.eye(3)
    with Recorder(path, joint_names=("1", "2"), metadata={"verb": "polish", "seed": "1", "mould": "dome"}) as recorder:
        for i in range(30):
            q, p = rng.normal(size=2), rng.normal(size=3)
            zeros = np.zeros(2)
            arm = Dynamics(
                t=0.01 * i, q=q, dq=q, p=p, R=eye, J=np.zeros((6, 2)), dJdq=np.zeros(6), M=np.eye(2), h=zeros, g=zeros
            )  # fmt: skip
            wanted = ToolReference(p=p, R=eye, v=np.zeros(6), a=np.zeros(6), normal=eye[2], force=10.0)
            recorder.record(Sample(arm, wanted, q, q), "pass")
    return path.read_bytes()


def forged(whole: bytes, rng: random.Random, path: Path) -> bytes:
    """A recording whose messages are damaged, with all its checksums right."""
    (raw,) = [found.raw for found in scan(whole) if isinstance(found, Content)]
    bad = damaged(raw, rng)
    table, _, end = messages(bad)
    with path.open("wb") as file:
        mcap = McapFile(file, 2**20)
        mcap.begin("burnish")
        mcap.note("burnish", {"verb": "polish"})
        mcap.describe(SCHEMAS, TOPICS)
        if len(table):
            mcap.write(np.frombuffer(bad[:end], dtype=np.uint8), table)
        mcap.finish()
    return path.read_bytes()


def a_box(binary: bool) -> bytes:
    """A box of 30 × 30 × 10 mm as an STL file."""
    corners = [(x, y, z) for x in (0, 30) for y in (0, 30) for z in (0, 10)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([[corners[k] for k in t] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype="<f4")
    if not binary:
        facets = "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle)
            + "endloop\nendfacet\n"
            for triangle in triangles.tolist()
        )
        return f"solid box\n{facets}endsolid box\n".encode()
    body = b"".join(bytes(12) + triangle.tobytes() + bytes(2) for triangle in triangles)
    return bytes(80) + len(triangles).to_bytes(4, "little") + body


def a_model(unit: str = "millimeter") -> bytes:
    """The box as the model of a 3MF file, built of two objects."""
    vertices, faces = shared_box()
    nodes = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return (
        f'<?xml version="1.0"?><model unit="{unit}"><resources><object id="1"><mesh><vertices>{nodes}</vertices>'
        f"<triangles>{triangles}</triangles></mesh></object>"
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>'
        '</resources><build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 2"/></build></model>'
    ).encode()


def packed(model: bytes) -> bytes:
    """A 3MF file with this model."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return file.getvalue()


def shared_box() -> tuple[list[tuple[int, int, int]], list[tuple[int, int, int]]]:
    """Vertices and faces of the box."""
    corners = [(x, y, z) for x in (0, 30) for y in (0, 30) for z in (0, 10)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]


def an_obj() -> bytes:
    """The box as an OBJ file, once in triangles and once in a polygon with textures."""
    vertices, faces = shared_box()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    return "\n".join([*lines, "f 1/1/1 2/2/2 4/3/3 3/4/4", "f -8 -7 -5", ""]).encode()


def a_ply(form: str) -> bytes:
    """The box as a PLY file."""
    vertices, faces = shared_box()
    head = (
        f"ply\nformat {form} 1.0\ncomment box\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if form == "ascii":
        rows = [f"{x} {y} {z}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
        return head + "\n".join([*rows, ""]).encode()
    order = "<" if form == "binary_little_endian" else ">"
    body = b"".join(struct.pack(f"{order}3f", *vertex) for vertex in vertices)
    return head + body + b"".join(struct.pack(f"{order}B3i", 3, *face) for face in faces)


def a_plan() -> bytes:
    """A plan of one stroke."""
    count = 20
    stroke = {
        "points": [[0.001 * i, 0.0, 0.01] for i in range(count)],
        "normals": [[0.0, 0.0, 1.0]] * count,
        "feed": [0.02] * count,
        "force": [10.0] * count,
    }
    return json.dumps({"strokes": [stroke]}).encode()


def a_recipe() -> bytes:
    """A recipe of two passes."""
    drawn = Polyline(points=((0.0, 0.0), (0.02, 0.0), (0.02, 0.01)))
    return as_toml(Recipe(force=8.0, grit="P400", passes=(Pass(pattern=CrossHatch()), Pass(pattern=drawn)))).encode()


def a_journal() -> bytes:
    """A job of one stroke that was stopped."""
    first = {"format": FORMAT, "order": {"mould": "dome", "seed": "1"}, "course": {"passes": 1}, "mould_sha256": "0"}
    mark = {"number": 1, "stroke": 1, "phase": "pass", "force": 9.8, "t": 3.0, "metres": 0.1, "joules": 0.3}
    marks = [mark | {"s": 0.01 * k} for k in range(20)]
    return "".join(json.dumps(line) + "\n" for line in [first, *marks]).encode()


def a_session() -> bytes:
    """A second of an operator."""
    return "\n".join([HEAD, *(f"{0.01 * k},{0.01 * k},0,0,0,0,-0.5,01" for k in range(50)), ""]).encode()


def read_recording(path: Path) -> None:
    """What `export` and `verify` do with a recording, and what `recover` does."""
    out = path.with_name("mended.mcap")
    out.unlink(missing_ok=True)
    refused: BurnishError | None = None
    try:
        for _ in Recording(path).blocks():
            pass
    except BurnishError as error:
        refused = error
    recover(path, out)
    for _ in Recording(out).blocks():
        pass
    if refused is not None:
        raise refused


def read_mould(path: Path) -> None:
    """What every verb does with a mesh, its unit left open."""
    Mould.load(str(path))


def readers(folder: Path) -> dict[str, tuple[list[bytes], str, Callable[[Path], object]]]:
    """For each kind of input: whole ones, the ending of their names, and what reads them."""
    recording = a_recording(folder / "whole.mcap")
    poses = b"".join(b"%r %r 0.3 0.5 -0.5 0.5 0.5\n" % (0.01 * i, 0.02 * i) for i in range(30))
    return {
        "recording": ([recording], ".mcap", read_recording),
        "forged recording": ([recording], ".mcap", read_recording),
        "mesh": ([a_box(binary=True), a_box(binary=False)], ".stl", read_mould),
        "obj mesh": ([an_obj()], ".obj", read_mould),
        "ply mesh": (
            [a_ply(form) for form in ("ascii", "binary_little_endian", "binary_big_endian")],
            ".ply",
            read_mould,
        ),
        "3mf mesh": ([packed(a_model())], ".3mf", read_mould),
        "forged 3mf mesh": ([a_model()], ".3mf", read_mould),
        "limits": ([Limits.jaco2().to_json().encode()], ".json", Limits.load),
        "recipe": ([a_recipe()], ".toml", read_recipe),
        "journal": ([a_journal()], ".jsonl", read_journal),
        "operator's session": ([a_session()], ".csv", read_script),
        "poses": ([poses], ".txt", read_poses),
        "plan": ([a_plan()], ".json", read_plan),
        "description": ([JACO2_URDF.read_bytes()], ".urdf", check_description),
    }


def fuzz(count: int, seed: int, part: int, folder: Path) -> dict[str, Any]:
    """Read ``count`` damaged files in turn; what came of them, and what must not have."""
    folder = folder / str(part)
    folder.mkdir(parents=True, exist_ok=True)
    rng = random.Random(f"{seed} {part}")
    kinds = readers(folder)
    tally: dict[str, dict[str, int]] = {name: {"read": 0, "refused": 0} for name in kinds}
    wrong: list[dict[str, object]] = []
    longest: dict[str, float] = dict.fromkeys(kinds, 0.0)
    # A warning is an overflow or a division by zero that nobody thought of.
    warnings.simplefilter("error")
    logging.disable(logging.WARNING)
    for number in range(count):
        name = list(kinds)[number % len(kinds)]
        whole, ending, read = kinds[name]
        path = folder / f"input{ending}"
        if name == "forged recording":
            path.write_bytes(forged(whole[0], rng, folder / "forged.mcap"))
        elif name == "forged 3mf mesh":
            path.write_bytes(packed(damaged(whole[0], rng)))
        else:
            path.write_bytes(damaged(rng.choice(whole), rng))
        start = time.process_time()
        try:
            read(path)
            tally[name]["read"] += 1
        except BurnishError:
            tally[name]["refused"] += 1
        except Exception as error:  # noqa: BLE001  Finding these is what this is for.
            where = traceback.extract_tb(error.__traceback__)[-1]
            wrong.append(
                {"number": number, "kind": name, "error": repr(error)[:200], "at": f"{where.name}:{where.lineno}"}
            )
            kept = folder / f"wrong-{number}{ending}"
            kept.write_bytes(path.read_bytes())
        taken = time.process_time() - start
        longest[name] = max(longest[name], taken)
        if taken > LONGEST:
            wrong.append({"number": number, "kind": name, "error": f"took {taken:.1f} s"})
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if memory > MOST:
        wrong.append({"error": f"the process took {memory / 2**20:.0f} MiB"})
    return {
        "inputs": tally,
        "longest_s": {name: round(value, 3) for name, value in longest.items()},
        "memory_MiB": round(memory / 2**20),
        "wrong": wrong,
    }


def main() -> int:
    """Say what came of it; exit status 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--count", type=int, default=100_000, metavar="N", help="damaged files (default: 100000)")
    parser.add_argument("--seed", type=int, default=1, metavar="K", help="of the damage (default: 1)")
    parser.add_argument("--out", type=Path, metavar="FILE.json", help="file for the result")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder for the inputs that went wrong")
    parser.add_argument("--parts", type=int, default=1, metavar="P", help="processes that share them (default: 1)")
    options = parser.parse_args()
    share = -(-options.count // options.parts)
    counts = [min(share, options.count - share * i) for i in range(options.parts)]
    with tempfile.TemporaryDirectory() as name, ProcessPoolExecutor(options.parts) as pool:
        folder = Path(name) if options.keep is None else options.keep
        seeds, folders = [options.seed] * options.parts, [folder] * options.parts
        results = list(pool.map(fuzz, counts, seeds, range(options.parts), folders))
    result: dict[str, Any] = {"count": options.count, "seed": options.seed, "parts": options.parts}
    result["inputs"] = {
        kind: {end: sum(part["inputs"][kind][end] for part in results) for end in ("read", "refused")}
        for kind in results[0]["inputs"]
    }
    result["longest_s"] = {kind: max(part["longest_s"][kind] for part in results) for kind in results[0]["longest_s"]}
    result["memory_MiB"] = max(part["memory_MiB"] for part in results)
    result["wrong"] = [fault for part in results for fault in part["wrong"]]
    text = json.dumps(result, indent=2)
    sys.stdout.write(text + "\n")
    if options.out is not None:
        options.out.write_text(text + "\n")
    return 1 if result["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
