"""What a verb has made, entered into the library: one line at the end of the verb, which never fails because of it."""

from __future__ import annotations

import sys
from pathlib import Path

from burnish.errors import BurnishError
from burnish.library import Library
from burnish.surface import bundled


def entered(
    folder: Path, *, mould: str | None = None, unit: str = "auto", recipe: str | None = None, shown: bool = False
) -> None:
    """Enter the folder of a job, and what it was made of. A library that cannot be written is said in one line.

    Args:
        folder: of the job.
        mould: bundled name or file of its mould.
        unit: of that file.
        recipe: file of its recipe.
        shown: whether its recording holds a demonstration.
    """
    try:
        with Library.open() as library:
            if mould is not None and mould not in bundled.NAMES:
                library.add_mould(mould, unit=unit)
            if recipe is not None:
                library.add_recipe(recipe)
            library.add_run(folder)
            if shown:
                library.add_demonstration(folder / "run.mcap")
    except BurnishError as error:
        print(f"burnish: not entered into the library: {' '.join(str(error).split())}", file=sys.stderr)
