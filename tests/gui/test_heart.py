"""The heart of a page in a real Chromium: it beats behind other tabs, and ends with the page."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

from burnish.gui.lease import Grant
from burnish.gui.server import Server

pytestmark = pytest.mark.slow
FLAGS = (
    "--no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert path is not None, "this needs a Chromium: apt install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    with Server(tmp_path, port=0) as server:
        yield server


def commanding(server: Server, context: BrowserContext, address: str) -> tuple[Page, int]:
    """A page that has the command, and its client."""
    clients: list[int] = []
    server.viser.on_client_connect(lambda client: clients.append(client.client_id))
    page = context.new_page()
    page.goto(address)
    wait(page, lambda: bool(clients) and server.take(clients[-1]) is not None)
    return page, clients[-1]


def wait(page: Page, until: Callable[[], bool]) -> None:
    """Let the browser go on until this is so."""
    end = time.monotonic() + 60.0
    while not until():
        assert time.monotonic() < end
        page.wait_for_timeout(50)


def test_page_keeps_the_command_while_it_is_there_and_no_longer(server: Server, chromium: Browser) -> None:
    context = chromium.new_context()
    page, client = commanding(server, context, server.url())
    grant = server.lease.grant
    page.wait_for_timeout(2000)
    assert server.lease.grant == grant
    # Another page of the same browser, with the same cookie, watches.
    other = context.new_page()
    other.goto(f"http://127.0.0.1:{server.port}/")
    other.wait_for_timeout(2000)
    assert server.lease.grant == grant
    assert all(server.take(who) is None for who in server.viser.get_clients() if who != client)
    page.close()
    wait(other, lambda: server.lease.grant is None)
    context.close()


def test_reloaded_page_has_to_take_command_anew(server: Server, chromium: Browser) -> None:
    context = chromium.new_context()
    page, client = commanding(server, context, server.url())
    lost: list[Grant] = []
    server._hearts._lost = lost.append
    page.reload()
    wait(page, lambda: bool(lost))
    wait(page, lambda: bool(server.viser.get_clients()))
    assert server.lease.grant is None
    assert not server.lease.holds(client)
    context.close()


def test_page_that_hangs_loses_the_command(server: Server, chromium: Browser, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("burnish.gui.heart.HANGS", 1.0)
    context = chromium.new_context()
    page, _ = commanding(server, context, server.url())
    page.evaluate("setTimeout(() => { const end = Date.now() + 6000; while (Date.now() < end); }, 100)")
    end = time.monotonic() + 5.0
    while server.lease.grant is not None and time.monotonic() < end:
        time.sleep(0.05)
    assert server.lease.grant is None
    context.close()


def test_page_asks_nobody_but_this_server(server: Server, chromium: Browser) -> None:
    context = chromium.new_context()
    asked: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    page, _ = commanding(server, context, server.url())
    own = (f"http://127.0.0.1:{server.port}/", "data:", "blob:")
    assert asked
    assert not [url for url in asked if not url.startswith(own)]
    told = page.evaluate("fetch('http://127.0.0.2:9/').then(() => 'open', (error) => 'closed')")
    assert told == "closed"
    context.close()
