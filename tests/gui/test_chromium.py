"""The workshop as a person meets it: a real Chromium, cut off from everything but this computer."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from gui_bench import CHROMIUM, FLAGS, block

MOST_CLICKS = 6
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not CHROMIUM.exists() and os.environ.get("CI") != "true", reason="there is no Chromium; CI has to have one"
    ),
]


@contextmanager
def workshop(folder: Path) -> Iterator[str]:
    """``burnish gui`` as a person starts it; its address."""
    line = "import sys; from burnish.commands.gui_options import add_gui; from burnish.commands.gui import run; "
    line += "from burnish.cli import Parser; parser = Parser(); add_gui(parser); sys.exit(run(parser.parse_args()))"
    command = [sys.executable, "-c", line, "--port", "0", "--library", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            yield re.fullmatch(r"workshop: (\S+)\n", process.stdout.readline())[1]
        finally:
            process.terminate()
            process.wait(90)


class Visitor:
    """A browser tab that counts its clicks."""

    def __init__(self, page) -> None:
        self.page, self.clicks = page, 0

    def click(self, locator) -> None:
        locator.click(timeout=60_000)
        self.clicks += 1

    def button(self, name: str):
        return self.page.get_by_role("button", name=name, exact=True)


@pytest.fixture
def browser() -> Iterator[tuple[object, list[str]]]:
    from playwright.sync_api import sync_playwright

    asked: list[str] = []
    with sync_playwright() as play:
        found = play.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        context = found.new_context(viewport={"width": 760, "height": 560})

        def gate(route) -> None:
            address = route.request.url
            if re.match(r"(https?|wss?)://127\.0\.0\.1:\d+/", address) or address.startswith(("data:", "blob:")):
                route.continue_()
            else:
                asked.append(address)
                route.abort()

        context.route("**/*", gate)
        yield context, asked
        found.close()


def test_a_newcomer_comes_from_an_stl_file_to_a_report_in_six_clicks(browser, tmp_path: Path) -> None:
    context, asked = browser
    with workshop(tmp_path / "library") as address:
        visitor = Visitor(context.new_page())
        visitor.page.goto(address)
        visitor.button("Stop").wait_for(timeout=60_000)
        with visitor.page.expect_file_chooser(timeout=60_000) as chooser:
            visitor.click(visitor.button("Upload STL, OBJ, PLY or 3MF"))
        chooser.value.set_files(block(tmp_path))
        visitor.click(visitor.button("Plan the path"))
        visitor.button("Start polishing").wait_for(timeout=120_000)
        visitor.click(visitor.button("Start polishing"))
        report = visitor.page.get_by_role("link", name="Open the report")
        report.wait_for(timeout=300_000)
        while visitor.button("Resume").is_visible() and visitor.clicks < MOST_CLICKS - 1:
            # A browser that draws without a graphics card may answer too late to command: the arm is then held.
            visitor.click(visitor.button("Resume"))
            report.wait_for(state="hidden", timeout=60_000)
            report.wait_for(timeout=300_000)
        with context.expect_page(timeout=60_000) as opened:
            visitor.click(report)
        opened.value.get_by_role("heading", name=re.compile("block")).first.wait_for(timeout=60_000)
        assert visitor.clicks <= MOST_CLICKS
        assert visitor.button("Do it again").is_visible()
        assert asked == []


def test_a_second_tab_only_watches_and_says_so(browser, tmp_path: Path) -> None:
    context, asked = browser
    with workshop(tmp_path / "library") as address:
        first = Visitor(context.new_page())
        first.page.goto(address)
        first.page.get_by_text("you command").wait_for(timeout=60_000)
        second = Visitor(context.new_page())
        second.page.goto(address.split("?")[0])
        second.page.get_by_text("you watch").wait_for(timeout=60_000)
        second.page.get_by_text("This tab only watches").wait_for(timeout=60_000)
        assert second.button("Stop").is_disabled()
        assert second.button("Upload STL, OBJ, PLY or 3MF").is_disabled()
        assert asked == []
        first.page.close()
        # Nobody commands any more; the watcher may take it, and has to want it.
        take = second.button("Take command")
        for _ in range(200):
            if take.is_enabled():
                break
            time.sleep(0.1)
        second.click(take)
        second.page.get_by_text("you command").wait_for(timeout=60_000)
