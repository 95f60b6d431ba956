"""`Gate`: who may talk to the workshop at all; asked before a socket opens or a byte of a file is read.

Bound to 127.0.0.1 alone. A request has to name this server (Host), come from no other page (Origin, Sec-Fetch-Site),
and carry the cookie of this run, which a browser gets for a one-time token in the address that is printed. From
elsewhere there is a tunnel that ends on this machine: ``ssh -L 8080:127.0.0.1:8080 …``.
"""

from __future__ import annotations

import hmac
import logging
import secrets
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any, TypeAlias

import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.frames import Frame
from websockets.http11 import Request, Response

from burnish.gui.bucket import Bucket
from burnish.gui.pages import Pages

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
"""What a browser may call this machine."""
MOST = 1 << 20
"""Longest message of a browser [bytes]; viser sends files in parts of half of that."""
RATE, BURST = 200.0, 400.0
"""Frames a second that a browser may send, and how many at once."""
BITS = 256
"""Of a token and of a cookie."""
VALID = 600.0
"""Time for which a token is taken [s]."""
OPENING = 5.0
"""Time in which a request has to be complete [s]."""
SOCKETS = 64
"""Most connections at once."""
OWN = ("/", "/index.html")
"""The page of viser, which is one file."""
Handler: TypeAlias = Callable[[ServerConnection], Awaitable[None]]
Answer: TypeAlias = Callable[[ServerConnection, Request], Response | None]
logger = logging.getLogger(__name__)
# Whoever sends what is no request is refused, and does not fill the terminal.
logger.addFilter(lambda record: record.getMessage() != "opening handshake failed")
_serving = threading.Lock()


class Gate:
    """Admits the browsers that were given the address, and nobody else."""

    def __init__(self, pages: Pages, hearts: Callable[[ServerConnection, str], Awaitable[None]]) -> None:
        """``pages`` are served beside the workshop; ``hearts`` gets the sockets at ``/heart/KEY`` with their key."""
        self._pages, self._hearts = pages, hearts
        self._tokens: dict[str, float] = {}
        self._cookies: list[str] = []
        self._lock = threading.Lock()
        self._open = 0

    def token(self) -> str:
        """A new token, for one browser, once."""
        token, now = secrets.token_urlsafe(BITS // 8), time.monotonic()
        with self._lock:
            self._tokens = {old: until for old, until in self._tokens.items() if until > now}
            self._tokens[token] = now + VALID
        return token

    def admit(self, request: Request, port: int) -> Response | None:
        """None lets the request through; else the answer to it, a refusal or the cookie."""
        if not _for_us(request.headers, port):
            return refusal(HTTPStatus.FORBIDDEN, "this address is not the workshop's: use the one that was printed")
        if not _from_us(request.headers, port):
            return refusal(HTTPStatus.FORBIDDEN, "another page asked for this: open the workshop's address by itself")
        path, _, query = request.path.partition("?")
        if path == "/" and query.startswith("token="):
            return self._exchange(query.removeprefix("token="), request.headers, port)
        if not self._known(request.headers, port):
            return refusal(HTTPStatus.UNAUTHORIZED, "open the address that 'burnish gui' printed; it works once")
        if _upgrades(request.headers):
            return None if path == "/" or path.startswith("/heart/") else missing()
        return None if path in OWN else self._pages.answer(path) or missing()

    @contextmanager
    def guarding(self) -> Iterator[None]:
        """Every server that websockets makes within this block, in whatever thread, has this gate before it."""
        with _serving:
            original = websockets.asyncio.server.serve

            def serve(handler: Handler, host: str, port: int, *, process_request: Answer, **options: Any) -> object:
                options |= {"max_size": MOST, "open_timeout": OPENING, "server_header": None, "logger": logger}
                return original(
                    self._routed(handler),
                    LOOPBACK,
                    port,
                    process_request=self._asked(process_request),
                    create_connection=Bounded,
                    **options,
                )

            websockets.asyncio.server.serve = serve  # type: ignore[assignment, misc]
            try:
                yield
            finally:
                websockets.asyncio.server.serve = original  # type: ignore[misc]

    def _asked(self, answer: Answer) -> Answer:
        """The gate's word first, then the page's own."""

        def asked(connection: ServerConnection, request: Request) -> Response | None:
            port = int(connection.local_address[1])
            verdict = self.admit(request, port)
            if verdict is not None or _upgrades(request.headers):
                return verdict
            found = answer(connection, request)
            if found is not None:
                for name, value in guards(_workshop(port)).items():
                    found.headers[name] = value
            return found

        return asked

    def _routed(self, handler: Handler) -> Handler:
        """Hearts to where they are listened to, the rest to the page's own handler; not too many of them."""

        async def routed(connection: ServerConnection) -> None:
            if self._open >= SOCKETS:
                await connection.close(1013, "too many connections")
                return
            self._open += 1
            try:
                path = "/" if connection.request is None else connection.request.path
                if path.startswith("/heart/"):
                    await self._hearts(connection, path.removeprefix("/heart/"))
                else:
                    await handler(connection)
            finally:
                self._open -= 1

        return routed

    def _exchange(self, token: str, headers: Headers, port: int) -> Response:
        """A cookie for a token, which is then worth nothing."""
        if headers.get_all("Sec-Purpose") or headers.get_all("Upgrade"):
            return refusal(HTTPStatus.FORBIDDEN, "this address is opened by a person, once")
        with self._lock:
            until = self._tokens.pop(token, 0.0)
            if until <= time.monotonic():
                return refusal(HTTPStatus.UNAUTHORIZED, "this address was used, or is too old: ask for a new one")
            cookie = secrets.token_urlsafe(BITS // 8)
            self._cookies.append(cookie)
        answer = refusal(HTTPStatus.SEE_OTHER, "welcome")
        answer.headers["Location"] = "/"
        answer.headers["Set-Cookie"] = f"{cookie_name(port)}={cookie}; HttpOnly; SameSite=Strict; Path=/"
        return answer

    def _known(self, headers: Headers, port: int) -> bool:
        """Whether the request has a cookie of this run."""
        # Cookies do not heed ports, so every server's has a name of its own.
        wanted = cookie_name(port)
        pairs = [pair.strip().partition("=") for line in headers.get_all("Cookie") for pair in line.split(";")]
        given = [value.encode("utf-8", "surrogateescape") for name, _, value in pairs if name == wanted]
        with self._lock:
            return len(given) == 1 and any(hmac.compare_digest(given[0], cookie.encode()) for cookie in self._cookies)


class Bounded(ServerConnection):
    """A browser that sends too many frames is dropped."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._bucket = Bucket(rate=RATE, most=BURST)

    def process_event(self, event: Any) -> None:
        """Count a frame, before anybody looks into it."""
        if isinstance(event, Frame) and not self._bucket.take():
            self.transport.abort()
            return
        super().process_event(event)


def cookie_name(port: int) -> str:
    """What the cookie of the server on this port is called."""
    return f"burnish-{port}"


def guards(policy: str) -> dict[str, str]:
    """The headers of every answer, with what a page of it may do."""
    return {
        "Content-Security-Policy": policy,
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "no-store",
    }


def refusal(status: HTTPStatus, text: str) -> Response:
    """An answer in plain words."""
    body = f"{text}\n".encode()
    headers = Headers(guards("default-src 'none'; frame-ancestors 'none'"))
    headers["Content-Type"], headers["Content-Length"] = "text/plain; charset=utf-8", str(len(body))
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)


def missing() -> Response:
    """There is no such page."""
    return refusal(HTTPStatus.NOT_FOUND, "there is no such page")


def _workshop(port: int) -> str:
    """What viser's page may do: run what it brought along, and talk to this server."""
    sockets = " ".join(f"ws://{name}:{port}" for name in NAMES)
    return (
        "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; worker-src 'self' blob:; "
        "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; media-src data: blob:; "
        f"connect-src 'self' data: blob: {sockets}; frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; "
        "form-action 'none'"
    )


def _upgrades(headers: Headers) -> bool:
    return bool(headers.get_all("Upgrade"))


def _for_us(headers: Headers, port: int) -> bool:
    """Whether the request names this server; another name that leads here is somebody else's page."""
    hosts = headers.get_all("Host")
    return len(hosts) == 1 and hosts[0] in {f"{name}:{port}" for name in NAMES}


def _from_us(headers: Headers, port: int) -> bool:
    """Whether no other page has sent the request; a socket always says which page it is."""
    origins, sites = headers.get_all("Origin"), headers.get_all("Sec-Fetch-Site")
    own = [f"http://{headers['Host']}"]
    if origins != own and (origins or _upgrades(headers)):
        return False
    return all(site in ("same-origin", "none") for site in sites)
