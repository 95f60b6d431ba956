"""`Pages`: files that the workshop serves beside itself, each found by what it is and a number, never by a path."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from http import HTTPStatus
from pathlib import Path
from typing import TypeAlias
from urllib.parse import quote

from websockets.datastructures import Headers
from websockets.http11 import Response

LARGEST = 256 << 20
"""Largest file that is served [bytes]; it is held in memory while it is."""
ADDRESS = re.compile(r"/([a-z]{1,16})/([A-Za-z0-9_-]{1,64})", re.ASCII)
POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
)
"""What a report may do: draw itself. It has no origin, so it can ask this server, or any other, for nothing."""
KINDS = {
    ".html": "text/html; charset=utf-8",
    ".png": "image/png",
    ".json": "application/json",
    ".csv": "text/csv; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
}
"""Endings and their content types; all others are bytes to be stored."""


@dataclass(frozen=True, kw_only=True)
class Page:
    """A file to serve."""

    path: Path
    """Where it lies, below the root."""
    save_as: str | None = None
    """Name under which a browser stores it; None shows it."""


Find: TypeAlias = Callable[[str], Page | None]


class Pages:
    """Kinds of pages, each with the function that finds one by its id; nothing outside the root is ever read."""

    def __init__(self, root: Path) -> None:
        """All files lie below ``root``."""
        self._root = root.resolve()
        self._finds: dict[str, Find] = {}

    def add(self, kind: str, find: Find) -> None:
        """Serve ``/kind/id`` as what ``find(id)`` names; None, or a file that is none, is a page that is not there."""
        self._finds[kind] = find

    def answer(self, path: str) -> Response | None:
        """The page at this path, or None. Whether it may be seen is settled before."""
        named = ADDRESS.fullmatch(path)
        find = self._finds.get(named[1]) if named else None
        page = find(named[2]) if named and find else None
        return None if page is None else self._read(page)

    def _read(self, page: Page) -> Response | None:
        try:
            path = page.path.resolve(strict=True)
            if not path.is_relative_to(self._root) or not path.is_file() or path.stat().st_size > LARGEST:
                return None
            body = path.read_bytes()
        except OSError:
            return None
        headers = Headers(
            {
                "Content-Type": KINDS.get(path.suffix.lower(), "application/octet-stream"),
                "Content-Length": str(len(body)),
                "Content-Security-Policy": POLICY,
                "X-Content-Type-Options": "nosniff",
                "Referrer-Policy": "no-referrer",
                "Cross-Origin-Resource-Policy": "same-origin",
                "Cache-Control": "no-store",
                "Connection": "close",
            }
        )
        if page.save_as is not None or path.suffix.lower() not in KINDS:
            name = quote(page.save_as or path.name, safe="")
            headers["Content-Disposition"] = f"attachment; filename*=UTF-8''{name}"
        return Response(HTTPStatus.OK.value, HTTPStatus.OK.phrase, headers, body)
