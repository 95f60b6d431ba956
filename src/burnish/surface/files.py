"""Reading the file of a part, whatever its kind, without trusting it."""

from __future__ import annotations

import stat
from pathlib import Path

import numpy as np

from burnish.core import Array
from burnish.errors import MouldError
from burnish.surface.obj import parse_obj
from burnish.surface.ply import parse_ply
from burnish.surface.stl import parse_stl
from burnish.surface.threemf import parse_3mf
from burnish.surface.units import METRES_PER_UNIT, check_unit, found_unit

MAX_BYTES = 64 * 2**20
"""Largest file that is read [bytes]: 64 MiB hold 1.3 million binary triangles."""

KINDS = "STL, OBJ, PLY or 3MF"


def read_mesh(path: Path, unit: str | None = None) -> tuple[Array, tuple[str, ...]]:
    """The triangles of an STL, OBJ, PLY or 3MF file; what it is, is told by its ending, and STL without one.

    Args:
        path: the file.
        unit: what one unit of the file is, ``mm``, ``m`` or ``inch``; None to find out. A 3MF file says so itself.

    Returns:
        Corners [m], in the file's axes, (F, 3, 3), and a sentence for everything that was assumed.

    Raises:
        MouldError: the file cannot be read, or it is not a whole file of finite numbers, or its unit is doubtful.
    """
    check_unit(unit)
    source, ending = str(path), path.suffix.lower()
    if ending in (".step", ".stp", ".iges", ".igs"):
        raise MouldError(f"{source} holds exact surfaces, not triangles; export the part as 3MF, or as {KINDS}")
    data = _bytes(path)
    if ending == ".3mf":
        said = (
            (f"a 3MF file names its own unit, which is taken instead of '{unit}'",) if unit not in (None, "mm") else ()
        )
        return parse_3mf(source, data), said
    corners = {".obj": parse_obj, ".ply": parse_ply}.get(ending, parse_stl)(source, data)
    assumed: tuple[str, ...] = ()
    if unit is None:
        unit, assumed = found_unit(source, np.ptp(corners, axis=(0, 1)))
    return corners * METRES_PER_UNIT[unit], assumed


def _bytes(path: Path) -> bytes:
    """The content of a regular, readable file of an acceptable size."""
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise MouldError(f"{path} is a directory; expected a file, {KINDS}: name the file inside it")
        if not stat.S_ISREG(status.st_mode):
            raise MouldError(f"{path} is not a regular file; expected {KINDS}")
        if status.st_size == 0:
            raise MouldError(f"{path} is empty; expected {KINDS}: export it again")
        if status.st_size > MAX_BYTES:
            raise MouldError(
                f"{path} has {status.st_size / 2**20:.0f} MiB; at most {MAX_BYTES // 2**20} MiB are read: "
                "reduce the number of triangles, or save it as binary STL"
            )
        with path.open("rb") as file:
            return file.read(status.st_size)
    except FileNotFoundError:
        raise MouldError(f"{path} does not exist; expected {KINDS}: check the name") from None
    except PermissionError:
        raise MouldError(f"{path} may not be read; allow this user to read it") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise MouldError(f"{str(path)!r} cannot be read ({error}); expected {KINDS}") from None
