import time
from datetime import datetime, timezone
from pathlib import Path

import pytest
from gui_bench import Hand, bench, block, gui

from burnish.gui.entries import BIN, compared, details, labels, line
from burnish.gui.page import Page
from burnish.library import RunRow
from burnish.polish.recipe import Recipe
from burnish.polish.recipe_file import write_recipe


@pytest.fixture(scope="module")
def panel():
    with gui() as found:
        yield found


@pytest.fixture
def work(tmp_path: Path):
    with bench(tmp_path) as found:
        found.library.add_mould(block(tmp_path), unit="mm")
        write_recipe(Recipe(force=6.0), tmp_path / "gentle.toml")
        found.library.add_recipe(tmp_path / "gentle.toml")
        yield found


@pytest.fixture
def tab(panel, work):
    panel.reset()
    return Page(panel, work, Hand()).library


def wait_for(condition) -> None:
    for _ in range(200):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not come")


def show(tab, kind: str) -> None:
    tab.kind.value = kind
    wait_for(lambda: tab.row is not None)


def test_what_was_uploaded_is_found_with_its_size_and_its_picture(tab) -> None:
    show(tab, "moulds")
    assert tab.row.name == "block"
    assert "40 × 40 × 10 mm" in tab.about.content
    assert f"/thumb/{tab.row.id}" in tab.picture.content
    assert f"/mesh/{tab.row.id}" in tab.links.content


def test_a_search_leaves_only_what_it_means(tab) -> None:
    show(tab, "moulds")
    tab.search.value = "teapot"
    wait_for(lambda: tab.row is None)
    assert "Nothing is found" in tab.found.content
    tab.search.value = "block"
    wait_for(lambda: tab.row is not None)


def test_a_name_and_tags_are_changed_and_the_change_is_undone(tab, work) -> None:
    show(tab, "moulds")
    tab.name.value, tab.tags.value, tab.notes.value = "door handle", "brass, customer 7", "left half"
    tab.save.value = True
    wait_for(lambda: work.library.moulds()[0].notes == "left half")
    row = work.library.moulds()[0]
    assert (row.name, sorted(row.tags)) == ("door handle", ["brass", "customer 7"])
    tab.undo.value = True
    wait_for(lambda: work.library.moulds()[0].name == "block" and work.library.moulds()[0].notes == "")
    wait_for(lambda: work.library.moulds()[0].tags == ())


def test_what_is_thrown_away_lies_in_the_bin_and_can_be_taken_back(tab, work) -> None:
    show(tab, "moulds")
    tab.throw.value = True
    wait_for(lambda: work.library.moulds() == [])
    show(tab, BIN)
    assert tab.throw.label == "Take out of the bin"
    tab.throw.value = True
    wait_for(lambda: len(work.library.moulds()) == 1)


def test_a_watcher_changes_nothing_in_the_library(tab, work) -> None:
    show(tab, "moulds")
    tab._page.command.mine = False
    tab.throw.value = True
    wait_for(lambda: "only watches" in tab._page.trouble.content)
    assert len(work.library.moulds()) == 1


def test_a_mould_and_a_recipe_are_put_onto_the_bench(tab, work) -> None:
    show(tab, "moulds")
    tab.use.value = True
    wait_for(lambda: work.part is not None)
    assert work.part.name == "block"
    tab.kind.value = "recipes"
    wait_for(lambda: tab.use.label == "Take this recipe")
    tab.use.value = True
    wait_for(lambda: work.edits.now.recipe.force == 6.0)


def test_entries_of_one_name_can_be_told_apart(work) -> None:
    row = work.library.moulds()[0]
    assert len(labels([row, row])) == 2
    assert line(row).startswith("block · ")


def test_details_have_units(work) -> None:
    assert dict(details(work.library.recipes()[0]))["force"] == "6.0 N"


def run_of(mould: str, **metrics: float) -> RunRow:
    """A job that is done."""
    day = datetime(2026, 3, 1, tzinfo=timezone.utc)
    return RunRow(
        id="1" * 32, name="2026-03-01_polish", created=day, files=(), tags=(), notes="", verb="polish", mould=mould,
        mould_sha256="0" * 64, arm="honest", sensor="wrist", ended="done", outcome="done", duration=60.0, folder="",
        metrics=metrics,
    )  # fmt: skip


def test_runs_are_told_apart_by_what_was_worked() -> None:
    assert line(run_of("hinge")) == "hinge · done · 2026-03-01_polish"


def test_compared_runs_say_what_was_worked_and_with_what_force() -> None:
    rows = compared(run_of("hinge", force_set_N=8.0, force_rms_N=0.2), run_of("frame", force_set_N=12.0))
    assert ("mould", "hinge", "frame") in rows
    assert ("arm", "honest, simulated", "honest, simulated") in rows
    assert ("set force", "8.0 N", "12.0 N") in rows
    assert rows[-1] == ("force error, RMS", "0.20 N", "–")
