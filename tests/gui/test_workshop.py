from pathlib import Path

import numpy as np
import pytest
from gui_bench import FakeJob, glance

from burnish.gui.files import row_of
from burnish.gui.page import Page
from burnish.gui.part import Part
from burnish.gui.planning import Preview
from burnish.gui.refusal import Refusal
from burnish.gui.server import Server
from burnish.gui.stage import Stage
from burnish.gui.workshop import Share, Workshop
from burnish.library import Library
from burnish.polish.cell import READY


@pytest.fixture(scope="module")
def part() -> Part:
    return Part.bundled("plate")


@pytest.fixture
def shop(tmp_path: Path):
    with Library.open(tmp_path / "library") as library, Server(library.root, 0) as server:
        found = Workshop(server, library)
        # A page that no browser shows stands for a viewer.
        found.pages[7] = Page(server.viser.gui, found.bench, Share(found, 7))
        yield found
        found.stop()


@pytest.fixture
def at_work(shop, part, tmp_path: Path):
    shop.bench.mount(part)
    shop.bench.preview = Preview(target=1e-8)
    shop.look()
    shop.bench.job, shop.bench.line = FakeJob(["polish"], tmp_path), ["polish"]
    shop.bench.folder, shop.bench.stage = tmp_path, Stage.RUNNING
    return shop


def looks(shop, times: int = 10) -> None:
    for _ in range(times):
        shop.look()


def test_the_arm_follows_the_job(at_work) -> None:
    at_work.bench.job.box.post(glance(q=READY))
    looks(at_work, 1)
    expected = at_work._model.link_poses(READY)["end_effector"][:3, 3]
    assert at_work.scene._links["end_effector"].position == pytest.approx(expected)


def test_what_the_job_rubs_is_painted_on_the_part(at_work) -> None:
    before = at_work.scene._glb.glb_data
    for x in np.linspace(-0.02, 0.02, 41):
        at_work.bench.job.box.mark(np.array([x, 0.0, 0.02]), 10.0, 0.02, 0.05)
    looks(at_work)
    paint = at_work.scene.paint
    touched = paint.canvas.vertices[paint.depth > 0.0]
    assert len(touched)
    assert np.abs(touched[:, 1]).max() < 0.01
    assert at_work.scene._glb.glb_data != before
    depth = paint.depth.copy()
    looks(at_work)
    assert (paint.depth == depth).all()


def test_another_job_begins_on_bare_steel_but_one_that_is_gone_on_with_does_not(at_work, tmp_path: Path) -> None:
    looks(at_work, 1)
    at_work.scene.paint.depth[:] = 1e-8
    at_work.bench.job, at_work.bench.line = FakeJob(["polish"], tmp_path), ["polish", "--resume", "x"]
    looks(at_work, 1)
    assert at_work.scene.paint.depth.all()
    at_work.bench.job, at_work.bench.line = FakeJob(["polish"], tmp_path), ["polish"]
    looks(at_work, 1)
    assert not at_work.scene.paint.depth.any()


def test_the_curves_show_force_against_its_set_value(at_work) -> None:
    at_work.bench.job.box.post(glance(force=9.1, force_set=10.0))
    looks(at_work)
    _, force, wanted = at_work.pages[7].live.plots.history.data(0)
    assert (force[-1], wanted[-1]) == (9.1, 10.0)
    assert "9.10 N, 10.00 N" in at_work.pages[7].live.state.content


def test_a_refused_plan_is_marked_on_the_part(shop, part) -> None:
    shop.bench.mount(part)
    shop.bench.preview = Preview(refusal=Refusal(why="Too fast.", at=np.array([0.0, 0.0, 0.02])))
    shop.look()
    assert any(handle.name.endswith("refused") for handle in shop.scene._strokes)


def test_nobody_commands_a_workshop_that_no_page_has_answered(shop) -> None:
    looks(shop)
    assert shop.server.lease.grant is None
    assert not Share(shop, 7).mine


def test_an_ended_job_is_noticed(at_work) -> None:
    at_work.bench.job.outcome = 2
    at_work.bench.job.said = "burnish: refused; do something else\n"
    looks(at_work, 1)
    assert at_work.bench.stage is Stage.FAILED
    assert "refused; do something else" in at_work.pages[7].trouble.content


def test_a_picture_of_a_pose_is_shown_while_nothing_runs(shop) -> None:
    shop.bench.pose(READY)
    shop.look()
    expected = shop._model.link_poses(READY)["end_effector"][:3, 3]
    assert shop.scene._links["end_effector"].position == pytest.approx(expected)


def test_an_id_that_is_none_has_no_file(shop) -> None:
    assert row_of(shop.library, "no-such-entry") is None
    for kind in ("report", "mesh", "thumb", "recording"):
        assert shop.server.pages.answer(f"/{kind}/no-such-entry") is None


def test_a_report_of_a_job_under_way_is_served_by_the_name_of_its_folder(shop) -> None:
    folder = shop.bench.runs / "2026-01-01_polish"
    folder.mkdir(parents=True)
    (folder / "report.html").write_text("<p>done")
    answer = shop.server.pages.answer("/report/2026-01-01_polish")
    assert answer is not None
    assert answer.body == b"<p>done"
