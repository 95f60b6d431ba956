"""`Server`: viser behind the gate, with the lease and the hearts of all its pages."""

from __future__ import annotations

import threading
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import viser
from typing_extensions import Self
from viser import _messages

from burnish.errors import BurnishError
from burnish.gui.gate import LOOPBACK, Gate
from burnish.gui.heart import Hearts
from burnish.gui.lease import Grant, Lease
from burnish.gui.pages import Pages
from burnish.gui.process import Process

PORT = 8080


class Server:
    """The workshop's server; a context manager. What is shown is made with `viser`, what is commanded by `start`."""

    def __init__(self, root: Path, port: int = PORT) -> None:
        """Serve on 127.0.0.1 alone, on this port or the next free one; 0 takes any. Pages lie below ``root``."""
        self.pages = Pages(root)
        """Files beside the workshop: reports, thumbnails, exports."""
        self.lease = Lease()
        """Which client commands: ``lease.holds(event.client_id)``."""
        self._job: Process | None = None
        self._starting = threading.Lock()
        self._hearts = Hearts(self.lease, self._beat, self._lost)
        self._gate = Gate(self.pages, self._hearts.listen)
        # Viser prints an address that the gate refuses.
        with self._gate.guarding(), redirect_stdout(StringIO()):
            self.viser = viser.ViserServer(host=LOOPBACK, port=port, verbose=False)
        """What the pages show."""
        for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
            # Nobody makes a public address of this.
            self.viser._websock_server.unregister_handler(message)
        self.viser.gui.configure_theme(show_share_button=False)
        self.viser.on_client_connect(self._came)
        self.viser.on_client_disconnect(lambda client: self._hearts.forget(client.client_id))

    @property
    def port(self) -> int:
        """The port."""
        return self.viser.get_port()

    def url(self) -> str:
        """A new address for one browser; it works once, within ten minutes."""
        return f"http://{LOOPBACK}:{self.port}/?token={self._gate.token()}"

    def take(self, client: int | None) -> Grant | None:
        """The command for this client; None if another has it, or its page does not answer."""
        return None if client is None else self._hearts.take(client)

    def leave(self, client: int) -> None:
        """The client gives the command back; a job that it commanded is held."""
        grant = self.lease.leave(client)
        if grant is not None:
            self._lost(grant)

    @property
    def job(self) -> Process | None:
        """The job that was started last, under way or done."""
        return self._job

    def start(self, words: list[str], client: int | None) -> Process:
        """Start a verb with these words, commanded by this client.

        Raises:
            BurnishError: the client does not command, or a job is under way.
        """
        with self._starting:
            grant = self.lease.grant
            if grant is None or grant.who != client:
                raise BurnishError("somebody else commands, or nobody does; take command first")
            if self._job is not None:
                if self._job.outcome is None:
                    raise BurnishError("a job is under way; wait for its end, or stop it")
                self._job.close()
            self._job = Process(words, grant)
            return self._job

    def close(self) -> None:
        """Order the job to stop, wait for its arm to be at rest, and end the server."""
        if self._job is not None:
            self._job.close()
        with redirect_stdout(StringIO()):
            self.viser.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _came(self, client: viser.ClientHandle) -> None:
        """A page has connected: give it a heart."""
        script = self._hearts.script(client.client_id)
        client._websock_connection.queue_message(_messages.RunJavascriptMessage(source=script))

    def _beat(self, grant: Grant, at: float) -> None:
        job = self._job
        if job is not None:
            job.beat(grant, at)

    def _lost(self, grant: Grant) -> None:
        job = self._job
        if job is not None:
            job.lost(grant)
