"""``burnish gui``: the workshop in a browser, for this computer alone."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import signal
import sys
import threading
import webbrowser
from types import FrameType

from burnish.errors import InputError
from burnish.gui.server import Server
from burnish.gui.workshop import Workshop
from burnish.library import Library
from burnish.library.shelf import FOLDER


def run(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C; the address is the only line that is printed."""
    if not 0 <= options.port <= 65535:
        raise InputError(f"--port {options.port} is out of range; expected 1 to 65535, or 0 for any free one")
    # The commander's heart is heard by a thread of its own, which must not wait long for the others.
    sys.setswitchinterval(1e-3)
    with Library.open(options.library) as library:
        # What a job makes is entered into this library too.
        os.environ[FOLDER] = str(library.root.resolve())
        # viser introduces itself on stdout, without the token that makes its address one.
        with contextlib.redirect_stdout(io.StringIO()):
            server = Server(library.root, options.port)
        with server:
            workshop = Workshop(server, library)
            _stop_on_signals(workshop)
            address = server.url()
            print(f"workshop: {address}", flush=True)
            if not options.no_browser:
                threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
            workshop.run()
    return 0


def _stop_on_signals(workshop: Workshop) -> None:
    """Ctrl-C and a polite kill end the workshop; a job that runs comes to rest first."""

    def end(number: int, frame: FrameType | None) -> None:
        workshop.stop()

    for name in (signal.SIGINT, signal.SIGTERM):
        signal.signal(name, end)
