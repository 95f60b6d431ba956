"""Files that are either whole or absent."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from burnish.errors import InputError


def write_atomically(path: Path, data: bytes) -> None:
    """Write ``data`` beside ``path`` and move it there, so that nobody ever reads half a file.

    Raises:
        InputError: if the folder cannot be written to, or the disk is full.
    """
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with draft.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise InputError(
            f"cannot write {path}: {error.strerror}; give a folder that exists, is writable and has space"
        ) from error
