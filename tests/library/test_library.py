"""The library as a program meets it; every test on SQLite and on a real PostgreSQL server."""

from __future__ import annotations

import threading
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest
from library.made import campaign, demonstration, job, mould, plan, recipe

from burnish.errors import InputError
from burnish.library import Library, MouldRow, RecipeRow, Row, RunRow
from burnish.model.tool import PolishingTool


def filled(library: Library, folder: Path) -> list[Row]:
    """One row of each kind."""
    return [
        library.add_mould(mould(folder)),
        library.add_tool(PolishingTool(), name="felt tip"),
        library.add_recipe(recipe(folder)),
        library.add_demonstration(demonstration(folder)),
        library.add_plan(plan(folder)),
        library.add_run(job(folder / "job")),
    ]


def test_what_is_entered_is_found_in_the_list_of_its_kind_with_its_files(library: Library, tmp_path: Path) -> None:
    rows = filled(library, tmp_path)
    lists = (
        library.moulds(),
        library.tools(),
        library.recipes(),
        library.demonstrations(),
        library.plans(),
        library.runs(),
    )
    assert [list(found) for found in lists] == [[row] for row in rows]
    for row in rows:
        assert library.get(type(row), row.id) == row
        assert library.file(row).read_bytes()
    assert library.file(rows[0]).read_bytes() == mould(tmp_path).read_bytes()
    assert library.check() == []


def test_another_program_reads_the_same_rows(library: Library, url: str | None, tmp_path: Path) -> None:
    rows = filled(library, tmp_path)
    with Library.open(library.root, url) as other:
        assert [other.get(type(row), row.id) for row in rows] == rows


def test_what_is_entered_twice_is_there_once_and_keeps_what_was_written_on_it(library: Library, tmp_path: Path) -> None:
    row = library.add_recipe(recipe(tmp_path))
    named = library.tag(library.note(library.rename(row, "for bonnets"), "wet"), "felt")
    library.bin(named)
    again = library.add_recipe(recipe(tmp_path), name="another name")
    assert again == named
    assert library.recipes() == [named]


def test_a_job_that_was_gone_on_with_stays_one_row_with_its_new_figures(library: Library, tmp_path: Path) -> None:
    folder = job(tmp_path / "job", force_rms_N=0.5)
    first = library.rename(library.add_run(folder), "left door")
    (folder / "metrics.json").write_text('{"force_rms_N": 0.25, "duration_s": 9.0}')
    (folder / "run-2.mcap").write_bytes(job(tmp_path / "other", seed=1).joinpath("run.mcap").read_bytes())
    second = library.add_run(folder)
    assert (second.id, second.name, second.created) == (first.id, "left door", first.created)
    assert second.metrics["force_rms_N"] == 0.25
    assert [file.role for file in second.files] == ["recording", "recording-2", "metrics", "journal", "report"]
    assert library.runs() == [second]
    # The figures that nobody has any more are not kept.
    assert library.check() == []


def test_a_search_finds_rows_in_which_all_words_occur_whatever_their_case(library: Library, tmp_path: Path) -> None:
    left = library.rename(library.add_recipe(recipe(tmp_path, 5.0)), "Bonnet left ÄGIR 100 %")
    right = library.note(library.add_recipe(recipe(tmp_path, 6.0)), "for the BONNET\nof the right side")
    assert {row.id for row in library.recipes("bonnet")} == {left.id, right.id}
    assert library.recipes("left BONNET ägir") == [left]
    assert library.recipes("bonnet left right") == []
    # What a database takes for a pattern is only a letter.
    assert library.recipes("100 %") == [left]
    assert library.recipes("%") == [left]
    assert library.recipes("_onnet") == []
    assert library.count(RecipeRow, "bonnet") == 2


def test_tags_are_put_on_taken_off_and_listed(library: Library, tmp_path: Path) -> None:
    row = library.add_recipe(recipe(tmp_path))
    tagged = library.tag(library.tag(library.tag(row, "felt"), "  door\n side "), "felt")
    assert tagged.tags == ("door side", "felt")
    assert library.recipes(tag="felt") == [tagged]
    assert library.tags() == ["door side", "felt"]
    assert library.untag(tagged, "felt").tags == ("door side",)
    assert library.recipes(tag="felt") == []


def test_lists_come_newest_first_and_in_pages(library: Library, tmp_path: Path) -> None:
    rows = [library.add_recipe(recipe(tmp_path, force)) for force in (3.0, 4.0, 5.0)]
    assert library.recipes() == rows[::-1]
    assert library.recipes(limit=1, offset=1) == [rows[1]]
    with pytest.raises(InputError, match="at most 1000"):
        library.recipes(limit=10_000)


def test_runs_are_found_by_mould_ending_verb_and_time(library: Library, tmp_path: Path) -> None:
    run = library.add_run(job(tmp_path / "job"))
    other = library.add_run(campaign(tmp_path / "campaign"))
    assert library.runs(mould="dome") == library.runs(mould="d" * 64) == library.runs(ended="done") == [run]
    assert library.runs(verb="campaign") == library.runs(ended="interrupted") == [other]
    now = datetime.now(timezone.utc)
    assert library.runs(since=now - timedelta(minutes=5)) == [other, run]
    assert library.runs(since=now + timedelta(minutes=5)) == []
    # The same moments as a clock five hours further east shows them.
    east = now.astimezone(timezone(timedelta(hours=5)))
    assert library.runs(since=east - timedelta(minutes=5)) == [other, run]
    assert library.runs(since=east + timedelta(minutes=5)) == []


def test_bin_hides_a_row_until_it_is_taken_out(library: Library, tmp_path: Path) -> None:
    row = library.add_recipe(recipe(tmp_path))
    binned = library.bin(row)
    assert library.recipes() == []
    assert library.binned() == [binned]
    assert library.restore(binned) == row
    assert library.recipes() == [row]


def test_emptied_bin_takes_the_files_with_it_but_not_those_that_others_have(library: Library, tmp_path: Path) -> None:
    shown = demonstration(tmp_path)
    folder = tmp_path / "job"
    folder.mkdir()
    (folder / "run.mcap").write_bytes(shown.read_bytes())
    run, kept = library.add_run(folder), library.add_demonstration(shown)
    gone = library.file(library.bin(library.add_recipe(recipe(tmp_path))))
    library.bin(run)
    assert library.empty_bin() == 2
    assert not gone.exists()
    assert library.file(kept).read_bytes() == shown.read_bytes()
    assert library.check() == []
    with pytest.raises(InputError, match="holds no run"):
        library.get(RunRow, run.id)


def test_bin_that_two_empty_at_once_is_empty_for_both(
    library: Library, url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.bin(library.add_recipe(recipe(tmp_path)))
    with Library.open(library.root, url) as other:
        listed = library.binned

        def and_then_emptied(limit: int = 50, offset: int = 0) -> list[Row]:
            rows = listed(limit, offset)
            other.empty_bin()
            return rows

        monkeypatch.setattr(library, "binned", and_then_emptied)
        assert library.empty_bin() == 0
    assert library.check() == []


def test_edit_of_a_row_that_is_gone_is_refused(library: Library, tmp_path: Path) -> None:
    row = library.bin(library.add_recipe(recipe(tmp_path)))
    library.empty_bin()
    with pytest.raises(InputError, match="holds no recipe"):
        library.rename(row, "again")


def test_names_are_one_clean_line_and_never_empty(library: Library, tmp_path: Path) -> None:
    row = library.add_recipe(recipe(tmp_path))
    assert library.rename(row, " a\x00b\n\tc‮ " + "x" * 500).name == "ab c " + "x" * 195
    assert library.note(row, "a\x00b\nc").notes == "ab\nc"
    with pytest.raises(InputError, match="without a name"):
        library.rename(row, "\n")


@pytest.mark.parametrize("called", ["../../evil.stl", "/etc/passwd.stl", "..\\..\\evil.stl", "a\x00b.stl"])
def test_name_of_an_upload_is_never_a_path(library: Library, tmp_path: Path, called: str) -> None:
    before = set(tmp_path.iterdir())
    row = library.upload(called, mould(tmp_path).read_bytes())
    assert isinstance(row, MouldRow)
    assert row.name in ("evil", "passwd", "ab")
    assert library.file(row).resolve().is_relative_to(library.root)
    assert set(tmp_path.iterdir()) - before == {mould(tmp_path)}


def test_uploads_become_rows_of_the_kind_that_their_ending_says(library: Library, tmp_path: Path) -> None:
    for path, kind in (
        (recipe(tmp_path), "recipe"),
        (plan(tmp_path), "plan"),
        (demonstration(tmp_path), "demonstration"),
    ):
        assert kind == library.upload(path.name, path.read_bytes()).KIND
    for called, content in (
        ("a.exe", b"MZ"),
        ("a.toml", b"no = recipe"),
        ("a.json", b"{}"),
        ("a.mcap", b"x"),
        ("a.stl", b""),
    ):
        with pytest.raises(InputError, match=r"^a\.\w+"):
            library.upload(called, content)
    assert library.check() == []


def test_export_is_a_copy_under_the_row_s_name_and_overwrites_nothing(library: Library, tmp_path: Path) -> None:
    row = library.rename(library.add_mould(mould(tmp_path)), "../bonnet: left/right")
    copy = library.export(row, tmp_path / "out")
    assert copy == tmp_path / "out" / "_bonnet_ left_right.stl"
    assert copy.read_bytes() == mould(tmp_path).read_bytes()
    with pytest.raises(InputError, match="exists"):
        library.export(row, tmp_path / "out")


def test_mould_has_a_picture_and_the_unit_that_it_was_given(library: Library, tmp_path: Path) -> None:
    row = library.add_mould(mould(tmp_path, 2.0), unit="inch")
    assert row.size == pytest.approx((0.0508, 0.0508, 0.254))
    assert (row.unit, row.triangles) == ("inch", 12)
    picture = library.thumbnail(row)
    assert picture is not None
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert library.thumbnail(library.add_recipe(recipe(tmp_path))) is None


def test_threads_that_enter_the_same_things_at_once_do_not_disturb_each_other(library: Library, tmp_path: Path) -> None:
    files = [recipe(tmp_path, force) for force in (3.0, 4.0, 5.0)]
    trouble: list[Exception] = []

    def work() -> None:
        try:
            for path in files:
                library.tag(library.add_recipe(path), threading.current_thread().name)
        except Exception as error:  # noqa: BLE001  Handed to the test.
            trouble.append(error)

    threads = [threading.Thread(target=work, name=f"t{i}") for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert trouble == []
    assert [row.tags for row in library.recipes()] == [("t0", "t1", "t2", "t3")] * 3
    assert library.check() == []
