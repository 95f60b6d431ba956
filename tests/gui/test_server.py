"""The server as a browser meets it, over real sockets."""

from __future__ import annotations

import asyncio
import http.client
import re
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from burnish.errors import BurnishError
from burnish.gui.gate import BURST, MOST
from burnish.gui.server import Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with Server(tmp_path_factory.mktemp("root"), port=0) as server:
        yield server


def get(server: Server, path: str, **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10.0)
    connection.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})
    return connection.getresponse()


def cookie(server: Server) -> str:
    answer = get(server, server.url().partition(str(server.port))[2])
    assert answer.status == 303
    return (answer.getheader("Set-Cookie") or "").partition(";")[0]


def opened(server: Server, path: str = "/", **headers: str) -> connect:
    origin = f"http://127.0.0.1:{server.port}"
    return connect(
        f"ws://127.0.0.1:{server.port}{path}",
        additional_headers=headers,
        origin=origin,  # type: ignore[arg-type]
        subprotocols=["viser-v1.1.1"],  # type: ignore[list-item]
        max_size=None,
    )


def test_page_comes_with_the_cookie_only_and_may_ask_nobody_else(server: Server) -> None:
    assert get(server, "/").status == 401
    answer = get(server, "/", Cookie=cookie(server))
    assert answer.status == 200
    policy = answer.getheader("Content-Security-Policy") or ""
    sources = re.search(r"connect-src ([^;]*)", policy)
    assert sources is not None
    assert set(sources[1].split()) == {
        "'self'", "data:", "blob:", f"ws://127.0.0.1:{server.port}", f"ws://localhost:{server.port}",
    }  # fmt: skip
    assert b"viser" in answer.read().lower()


def test_socket_opens_with_the_cookie_only(server: Server) -> None:
    async def tried(**headers: str) -> int:
        try:
            async with opened(server, **headers):
                return 101
        except InvalidStatus as error:
            return error.response.status_code

    assert asyncio.run(tried()) == 401
    assert asyncio.run(tried(Cookie="burnish=1")) == 401
    assert asyncio.run(tried(Cookie=cookie(server))) == 101


def test_server_listens_on_loopback_alone(server: Server) -> None:
    with socket.create_server(("127.0.0.2", server.port)):
        # Another address of this machine is free, so the server is not on all of them.
        pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("::1", server.port), timeout=1.0)


@pytest.mark.parametrize("line", [b"POST / HTTP/1.1", b"GET / HTTP/1.0", b"GET http://127.0.0.1/ HTTP/1.1", b"junk"])
def test_other_requests_than_a_browsers_get_nothing(server: Server, line: bytes) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=10.0) as raw:
        raw.sendall(line + f"\r\nHost: 127.0.0.1:{server.port}\r\nCookie: {cookie(server)}\r\n\r\n".encode())
        answer = raw.recv(65536)
    assert b" 200 " not in answer.partition(b"\r\n")[0]
    assert b" 101 " not in answer.partition(b"\r\n")[0]


async def fate(connection: ClientConnection) -> int | None:
    """The code with which the server has closed."""
    try:
        while True:
            await asyncio.wait_for(connection.recv(), 10.0)
    except ConnectionClosed as closed:
        return None if closed.rcvd is None else closed.rcvd.code


@pytest.mark.parametrize("message", [b"x" * (MOST + 1), "text", b"\xc1", b"\x80", b"\x81\xa4type\xa4none"])
def test_giant_and_malformed_messages_end_their_own_socket_only(
    server: Server, message: bytes | str, caplog: pytest.LogCaptureFixture
) -> None:
    pair = cookie(server)

    async def sent() -> int | None:
        async with opened(server, Cookie=pair) as connection:
            await connection.send(message)
            return await fate(connection)

    code = asyncio.run(sent())
    assert code == (1009 if len(message) > MOST else 1011)
    assert get(server, "/", Cookie=pair).status == 200


def test_flood_ends_its_socket(server: Server) -> None:
    pair = cookie(server)

    async def flooded() -> int | None:
        async with opened(server, Cookie=pair) as connection:
            try:
                for _ in range(int(4 * BURST)):
                    await connection.ping()
            except ConnectionClosed:
                return None
            return await fate(connection)

    assert asyncio.run(flooded()) is None
    assert get(server, "/", Cookie=pair).status == 200


def test_nobody_makes_a_public_address(server: Server) -> None:
    handled = [kind.__name__ for kind in server.viser._websock_server._incoming_handlers]
    assert handled
    assert not [name for name in handled if name.startswith("ShareUrl")]


class Page:
    """A page's two sockets, without a browser: it answers its heart for as long as it is told to."""

    def __init__(self, server: Server, pair: str) -> None:
        self.server, self.pair = server, pair
        self.answers = True
        self.closing = threading.Event()
        self.beating = threading.Event()
        self.who = -1
        self._thread = threading.Thread(target=lambda: asyncio.run(self._live()))

    def __enter__(self) -> Page:
        before = set(self.server._hearts._whose.values())
        # What viser's page does when it has drawn itself for the first time.
        self.who = max([*before, 100]) + 1
        script = self.server._hearts.script(self.who)
        found = re.search(r'"(/heart/[^"]+)"', script)
        assert found is not None
        self.path = found[1]
        self._thread.start()
        assert self.beating.wait(10.0)
        return self

    def __exit__(self, *exception: object) -> None:
        self.closing.set()
        self._thread.join()

    async def _live(self) -> None:
        async with opened(self.server, self.path, Cookie=self.pair) as heart:
            listening = True
            while not self.closing.is_set():
                if self.server._hearts._seen.get(self.who):
                    self.beating.set()
                if listening != self.answers:
                    # Bytes that nobody reads get no pong.
                    listening = self.answers
                    (heart.transport.resume_reading if listening else heart.transport.pause_reading)()  # type: ignore[attr-defined]
                await asyncio.sleep(0.02)


def test_one_page_commands_and_another_watches(server: Server) -> None:
    pair = cookie(server)
    with Page(server, pair) as one, Page(server, pair) as two:
        grant = server.take(one.who)
        assert grant is not None
        assert server.take(two.who) is None
        time.sleep(0.5)
        assert server.lease.grant == grant
        with pytest.raises(BurnishError, match="take command first"):
            server.start(["polish"], two.who)
        server.leave(one.who)
        assert server.take(two.who) is not None


def test_page_that_no_longer_answers_loses_the_command_for_good(server: Server) -> None:
    with Page(server, cookie(server)) as page:
        assert server.take(page.who) is not None
        page.answers = False
        time.sleep(1.0)
        assert server.lease.grant is None
        assert server.take(page.who) is None
        page.answers = True
        time.sleep(0.5)
        assert server.lease.grant is None
        assert server.take(page.who) is not None


def test_page_that_is_closed_loses_the_command(server: Server) -> None:
    lost: list[object] = []
    with Page(server, cookie(server)) as page:
        assert server.take(page.who) is not None
        server._hearts._lost = lost.append  # type: ignore[method-assign, assignment]
    for _ in range(100):
        if lost:
            break
        time.sleep(0.05)
    server._hearts._lost = server._lost  # type: ignore[method-assign]
    assert len(lost) == 1
    assert server.lease.grant is None


def test_page_without_a_heart_cannot_command(server: Server) -> None:
    assert server.take(None) is None
    assert server.take(77) is None


def test_key_that_was_not_given_has_no_heart(server: Server) -> None:
    pair = cookie(server)

    async def knocked() -> int | None:
        async with opened(server, "/heart/" + "x" * 43, Cookie=pair) as heart:
            return await fate(heart)

    assert asyncio.run(knocked()) == 1008


def test_client_that_is_gone_takes_its_key_along(server: Server) -> None:
    first, second = server._hearts.script(500), server._hearts.script(500)
    assert first != second
    assert list(server._hearts._whose.values()).count(500) == 1
    server._hearts.forget(500)
    assert 500 not in server._hearts._whose.values()


def test_page_that_hangs_proves_nothing_by_its_browser(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("burnish.gui.heart.HANGS", 0.8)
    # This page's socket answers every ping, and it sends no number back.
    with Page(server, cookie(server)) as page:
        assert server.take(page.who) is not None
        time.sleep(2.0)
        assert server.lease.grant is None


def test_address_is_new_every_time(server: Server) -> None:
    assert server.url() != server.url()


def test_root_is_where_pages_are_read_from(tmp_path: Path) -> None:
    from burnish.gui.pages import Page as File

    (tmp_path / "a.txt").write_text("hello")
    with Server(tmp_path, port=0) as server:
        server.pages.add("text", lambda name: File(path=tmp_path / f"{name}.txt"))
        pair = cookie(server)
        assert get(server, "/text/a", Cookie=pair).read() == b"hello"
        assert get(server, "/text/a").status == 401
        assert get(server, "/text/b", Cookie=pair).status == 404
