"""A progress bar on a terminal, nothing in a pipe."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as RichProgress
from typing_extensions import Self

REFRESH = 0.1
"""Least time between two updates [s]: drawing costs more than a control cycle."""


class Progress:
    """What is being done, and how far it has come; on stderr, and only if that is a terminal."""

    def __init__(self, tell: Callable[[str], None] = lambda stage: None) -> None:
        """``tell`` is told of every stage."""
        self._console = Console(stderr=True)
        self._bar = RichProgress(
            TextColumn("{task.description:<20}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=self._console,
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task("starting", total=1.0)
        self._next = 0.0
        self._tell = tell

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()

    def stage(self, name: str) -> None:
        """Name what is being done now."""
        self._tell(name)
        self._bar.update(self._task, description=name, refresh=True)

    def update(self, name: str, share: float) -> None:
        """Name and share of the work, 0 to 1; cheap enough for every control cycle."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + REFRESH
            self._bar.update(self._task, description=name, completed=min(share, 1.0))

    def warn(self, text: str) -> None:
        """A line that stays."""
        self._console.print(f"burnish: {text}", markup=False)
