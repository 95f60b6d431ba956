"""`Hearts`: how the workshop knows that a browser's page is there.

Each page holds a socket for this alone. Twenty times a second the server pings it: the browser itself answers, at once
and whatever its page draws, and a page that is closed takes the socket with it. Proof is the time at which a ping
that was answered was *sent*, so what a network has held up proves nothing. Twice a second the page has to send a number
back as well, so one that hangs loses the command too. No clock of the browser is in it, because those are slowed in
a page that nobody looks at.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import threading
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass, field

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from burnish.gui.lease import Grant, Lease

PING = 0.05
"""Time between two pings [s]."""
TICKS = 10
"""Pings between two numbers that the page itself has to send back."""
UNDER_WAY = 20
"""Pings that may be unanswered."""
HANGS = 5.0
"""Time without an answer of the page after which the browser's count no more [s]; a large mould is drawn in seconds."""
SCRIPT = """
if (window.burnishHeart) { window.burnishHeart.onclose = null; window.burnishHeart.close(); }
const beat = () => {
  const socket = new WebSocket("ws://" + location.host + PATH);
  socket.onmessage = (tick) => socket.send(tick.data);
  socket.onclose = () => setTimeout(beat, 1000);
  window.burnishHeart = socket;
};
beat();
"""


@dataclass
class _Page:
    """What is known of one page's socket."""

    answered: float = field(default_factory=time.monotonic)
    """When the page itself answered last [s]."""


class Hearts:
    """The hearts of all pages, each known by a key that its page alone was told."""

    def __init__(self, lease: Lease, beat: Callable[[Grant, float], None], lost: Callable[[Grant], None]) -> None:
        """``beat`` is told when the commander was there [s, monotonic], ``lost`` that a commander is gone for sure."""
        self._lease, self._beat, self._lost = lease, beat, lost
        self._whose: dict[str, int] = {}
        self._seen: dict[int, float] = {}
        self._lock = threading.Lock()

    def script(self, who: int) -> str:
        """What the page of this client has to run, with a new key."""
        key = secrets.token_urlsafe(32)
        with self._lock:
            self._whose = {old: client for old, client in self._whose.items() if client != who} | {key: who}
        return SCRIPT.replace("PATH", json.dumps(f"/heart/{key}"))

    def forget(self, who: int) -> None:
        """The client is gone: so is its key, and its command."""
        with self._lock:
            self._whose = {key: client for key, client in self._whose.items() if client != who}
            self._seen.pop(who, None)
        self._end(who)

    def take(self, who: int) -> Grant | None:
        """The command for this client, if nobody else has it and its heart beats."""
        with self._lock:
            seen = self._seen.get(who, -1.0)
        return self._lease.take(who) if time.monotonic() - seen <= self._lease.term else None

    async def listen(self, connection: ServerConnection, key: str) -> None:
        """One page's heart, to its end."""
        with self._lock:
            who = self._whose.get(key)
        if who is None:
            await connection.close(1008, "no such page")
            return
        page = _Page()
        pinging = asyncio.create_task(self._ping(connection, who, key, page))
        try:
            async for _ in connection:
                page.answered = time.monotonic()
        except ConnectionClosed:
            # However it ended.
            return
        finally:
            pinging.cancel()
            self._end(who)

    async def _ping(self, connection: ServerConnection, who: int, key: str, page: _Page) -> None:
        """Ping until the socket is closed, whether or not earlier pings have come back."""
        count, under_way = 0, set[asyncio.Task[None]]()

        async def proof(answer: Awaitable[float], at: float) -> None:
            with suppress(ConnectionClosed):
                await answer
                if time.monotonic() - page.answered <= HANGS:
                    self._was_there(who, key, at)

        try:
            while True:
                if count % TICKS == 0:
                    await connection.send(str(count))
                count += 1
                if len(under_way) < UNDER_WAY:
                    at = time.monotonic()
                    task = asyncio.create_task(proof(await connection.ping(), at))
                    under_way.add(task)
                    task.add_done_callback(under_way.discard)
                await asyncio.sleep(PING)
        except ConnectionClosed:
            return

    def _was_there(self, who: int, key: str, at: float) -> None:
        """The page was there at this time [s]."""
        with self._lock:
            if self._whose.get(key) != who:
                return
            self._seen[who] = at
        grant = self._lease.renew(who, at)
        if grant is not None:
            self._beat(grant, at)

    def _end(self, who: int) -> None:
        grant = self._lease.leave(who)
        if grant is not None:
            self._lost(grant)
