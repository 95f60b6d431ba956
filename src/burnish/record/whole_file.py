"""A file that appears whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from burnish.errors import InputError


@contextmanager
def whole_file(out: Path) -> Iterator[IO[bytes]]:
    """A file beside ``out`` that takes its place at the end; gone if that is not reached.

    Raises:
        InputError: if it cannot be written.
    """
    part = out.with_name(out.name + ".part")
    try:
        with part.open("wb") as file:
            yield file
        os.replace(part, out)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror}; choose another file with --out") from error
    finally:
        part.unlink(missing_ok=True)
