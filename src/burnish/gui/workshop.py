"""The workshop: one bench, one scene, and a page for every browser tab, kept up to date 20 times a second."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass

import numpy as np
import viser

from burnish.errors import BurnishError, InputError
from burnish.gui import files, theme
from burnish.gui.bench import Bench
from burnish.gui.page import Page
from burnish.gui.part import Part
from burnish.gui.planning import Preview
from burnish.gui.scene import CAMERA, FIELD, LOOK_AT, Scene
from burnish.gui.server import Server
from burnish.library import Library
from burnish.model.model import Model
from burnish.runtime.glance import Glance

_LOG = logging.getLogger(__name__)
RATE = 20.0
"""Looks at the job and poses of the arm [Hz]."""
PAINTED, DRAWN = 4, 5
"""Looks from one painting of the mould, and from one drawing of the curves, to the next."""
PATIENCE = 1.0
"""Time that a page has to show that it is there, when it wants the command [s]."""


@dataclass(frozen=True)
class Share:
    """A client's share in the command."""

    workshop: Workshop
    client: int

    @property
    def mine(self) -> bool:
        """Whether it commands; while nothing moves, whoever commanded last still does as long as nobody else does."""
        if self.workshop.server.lease.holds(self.client):
            return True
        return self.free and not self.workshop.bench.live and self.workshop.commander == self.client

    @property
    def free(self) -> bool:
        """Whether nobody does."""
        return self.workshop.server.lease.grant is None

    def take(self) -> None:
        """Take it, now or within `PATIENCE`.

        Raises:
            InputError: another client has it, or this one does not answer fast enough to command.
        """
        end = time.monotonic() + PATIENCE
        while self.workshop.server.take(self.client) is None:
            if not self.free or time.monotonic() > end:
                raise InputError("another tab commands, or this one answers too slowly; close the other one, or wait")
            time.sleep(0.02)
        self.workshop.commander = self.client


class Workshop:
    """What ``burnish gui`` serves."""

    def __init__(self, server: Server, library: Library) -> None:
        """Furnish a server; `run` keeps it alive."""
        self.server, self.library = server, library
        self.bench = Bench(library, server.start)
        # The panel goes first: a picture that is there already would be drawn again in the room that is left.
        theme.configure(server.viser.gui, dark=False)
        server.viser.gui.set_panel_label("burnish workshop")
        server.viser.gui.main_panel.dock_right()
        server.viser.gui.main_panel.set_width(theme.WIDTH)
        self.scene = Scene(server.viser.scene)
        self.pages: dict[int, Page] = {}
        self._eager: set[int] = set()
        self.commander = -1
        """The client who commands, or who did last."""
        self._model = Model.jaco2()
        self._drawn: tuple[Part | None, Preview | None] = (None, None)
        self._job: object = None
        self._read = 0
        self._seen = -1
        self._posed = self.bench.shown
        self._count = 0
        self._lock = threading.Lock()
        self._over = threading.Event()
        camera = server.viser.initial_camera
        camera.position, camera.look_at, camera.fov = CAMERA, LOOK_AT, FIELD
        files.offer(server.pages, library, self.bench.runs)
        server.viser.on_client_connect(self._welcome)
        server.viser.on_client_disconnect(self._farewell)

    def run(self) -> None:
        """Look and show until `stop`."""
        late = time.monotonic()
        while not self._over.wait(max(0.0, late - time.monotonic())):
            late = max(late + 1.0 / RATE, time.monotonic())
            try:
                self.look()
            except BurnishError as error:
                _LOG.warning("%s", error)

    def stop(self) -> None:
        """End `run`."""
        self._over.set()
        self.bench.close()

    def look(self) -> None:
        """Take up what has happened and show it."""
        bench = self.bench
        bench.look()
        self._count += 1
        if (bench.part, bench.preview) != self._drawn:
            self._mount()
        glance = self._follow()
        painting = self._count % PAINTED == 0
        if painting:
            self._paint()
        with self._lock:
            pages = list(self.pages.items())
        for client, page in pages:
            self._offer_command(client)
            if self._count % PAINTED == 0 or bench.looked != page.looked:
                page.refresh(glance)
            if self._count % DRAWN == 0:
                page.draw()

    def _follow(self) -> Glance | None:
        """The arm as the job shows it, in the scene and on the curves."""
        job = self.bench.job
        if job is not self._job:
            self._job, self._read, self._seen = job, 0, -1
            # Lines would hide what is painted.
            self.scene.show_plan(False)
            if self.scene.paint is not None and "--resume" not in self.bench.line:
                self.scene.paint.depth[:] = 0.0
                self.scene.repaint()
        if self.bench.shown is not self._posed and not self.bench.live:
            self._posed = self.bench.shown
            self.scene.move(self._posed)
        if job is None or not self.bench.live:
            return None
        glance = job.box.latest()
        if glance is not None and glance.number != self._seen:
            self._seen = glance.number
            self.scene.move(glance.q)
            margin = float(np.min(self._model.limit_distance(glance.q)))
            with self._lock:
                for page in self.pages.values():
                    page.live.add(glance, margin)
        return glance

    def _paint(self) -> None:
        """What was rubbed since the last time."""
        job, paint = self.bench.job, self.scene.paint
        if job is None or paint is None or not self.bench.live:
            return
        self._read, rows = job.box.track(self._read)
        if len(rows):
            paint.rub(rows[:, :3], rows[:, 3], rows[:, 4] * rows[:, 5])
            self.scene.repaint()

    def _mount(self) -> None:
        """Draw another part, or another plan."""
        part, preview = self._drawn
        bench = self.bench
        if bench.part is not part and bench.part is not None:
            self.scene.put(bench.part.mould, bench.part.canvas, bench.edits.now.recipe.tool)
        if bench.preview is not preview or bench.part is not part:
            shown = bench.preview
            if shown is None:
                self.scene.plan(())
            elif shown.refusal is not None:
                self.scene.plan(shown.strokes, shown.refusal.at, shown.refusal.why)
            else:
                self.scene.plan(shown.strokes)
                if self.scene.paint is not None and shown.target > 0.0:
                    self.scene.paint.target = shown.target * bench.edits.now.passes
        self._drawn = (bench.part, bench.preview)

    def _welcome(self, client: viser.ClientHandle) -> None:
        page = Page(client.gui, self.bench, Share(self, client.client_id))
        with self._lock:
            self.pages[client.client_id] = page
            if self.server.lease.grant is None and self.commander not in self.pages:
                self._eager.add(client.client_id)

    def _farewell(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self.pages.pop(client.client_id, None)
            self._eager.discard(client.client_id)

    def _offer_command(self, client: int) -> None:
        """While nothing moves: whoever commanded last goes on, and so does a page that found nobody when it came."""
        grant = self.server.lease.grant
        if grant is not None:
            self.commander = grant.who
            self._eager.clear()
            return
        found_nobody = client in self._eager and self.commander not in self.pages
        if not self.bench.live and (client == self.commander or found_nobody):
            self.server.take(client)
