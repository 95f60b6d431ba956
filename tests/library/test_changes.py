"""A change that is cut off after each of its steps is done or undone as a whole by whoever comes next."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from library.made import recipe

from burnish.errors import InputError
from burnish.library import Library, changes


class Killed(BaseException):
    """The end of a process; nothing in the library catches it."""


def at_call(number: int, function: Callable[..., object]) -> Callable[..., object]:
    """The function, but its call of this number ends the process."""
    calls = iter(range(1, 1000))

    def called(*words: object, **named: object) -> object:
        if next(calls) == number:
            raise Killed
        return function(*words, **named)

    return called


STEPS = [
    # The change was sealed in all of these: its maker had done none, some, or all of it but removing the folder.
    ("place", 1, True),
    ("write_whole", 2, True),
    ("entry_of", 1, True),
    # Nothing was sealed yet.
    ("write_whole", 1, False),
    ("card_of", 1, False),
]


@pytest.mark.parametrize(("step", "call", "done"), STEPS)
def test_new_row_is_there_as_a_whole_or_not_at_all(
    library: Library, url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, call: int, done: bool
) -> None:
    library.add_recipe(recipe(tmp_path, 3.0))
    with monkeypatch.context() as patch:
        patch.setattr(changes, step, at_call(call, getattr(changes, step)))
        with pytest.raises(Killed):
            library.add_recipe(recipe(tmp_path, 4.0))
    with Library.open(library.root, url) as other:
        assert [row.force for row in other.recipes()] == ([4.0, 3.0] if done else [3.0])
        assert other.check() == []
    assert list((library.root / "changes").iterdir()) == []


def test_change_that_was_all_made_but_not_cleared_away_is_made_again_to_no_effect(
    library: Library, url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = library.add_recipe(recipe(tmp_path, 3.0))
    library.bin(library.add_recipe(recipe(tmp_path, 4.0)))
    make = changes._apply

    def made(*words: object) -> None:
        make(*words)  # type: ignore[arg-type]
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(changes, "_apply", made)
        with pytest.raises(Killed):
            library.empty_bin()
    with Library.open(library.root, url) as other:
        assert (other.recipes(), other.binned()) == ([kept], [])
        assert other.check() == []


@pytest.mark.parametrize("step", ["entry_of", "write_whole"])
def test_later_edit_is_not_undone_by_what_a_killed_process_left(
    library: Library, url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    row = library.add_recipe(recipe(tmp_path))
    with monkeypatch.context() as patch:
        patch.setattr(changes, step, at_call(2 if step == "write_whole" else 1, getattr(changes, step)))
        with pytest.raises(Killed):
            library.rename(row, "first")
    renamed = library.tag(row, "felt")
    assert (renamed.name, renamed.tags) == ("first", ("felt",))
    with Library.open(library.root, url) as other:
        assert other.recipes() == [renamed]


def test_what_another_process_prepares_at_this_moment_is_left_alone(
    library: Library, url: str | None, tmp_path: Path
) -> None:
    with changes.prepared(library.root) as folder, Library.open(library.root, url) as other:
        (folder / "half.mcap").write_bytes(b"...")
        other.add_recipe(recipe(tmp_path))
        assert (folder / "half.mcap").exists()
    assert not folder.exists()


def test_library_that_somebody_else_writes_for_too_long_is_refused(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(changes, "PATIENCE", 0.05)
    row = library.add_recipe(recipe(tmp_path))
    with changes.locked(library.root), pytest.raises(InputError, match="another program"):
        library.rename(row, "name")
