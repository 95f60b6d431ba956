"""What the workshop costs: its server, its colours, its first view, and the job beside it.

    python benchmarks/gui.py --out benchmarks/results/gui.json

The server shows a job at 20 Hz on the bundled mould (about 10,000 vertices) to viewers that take all that is sent
and draw nothing, because on this machine they would share the server's cores with a drawing in software; the first
view is a real Chromium's, drawing in software, by turns with a page of the same maker that holds one button. The job
is the simulated arm, held by a torque law at 100 Hz by the clock on the wall, with a glance at 50 Hz and a row of the
contact track every 10 ms, six times as often as a job at 20 mm/s has one. Its late cycles are counted in blocks with
server and viewers and, between them, in blocks in which these stand still (SIGSTOP); so both share every other load of
the machine.
"""

from __future__ import annotations

import argparse
import http.client
import json
import multiprocessing
import os
import re
import signal
import sys
import tempfile
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from common import machine, write_json
from gui_bench import CHROMIUM, FLAGS

from burnish.runtime.mailbox import Glance, Mailbox

MOULD, RATE = "mould", 100.0
VIEWERS, VIEWS = 3, 5
LATE = 1.0
"""Periods after its time from which on a cycle is late."""


def serve(pipe: Connection, box: str, library: str) -> None:
    """The server's process: a workshop that shows the job of a mailbox."""
    from burnish.gui.part import Part
    from burnish.gui.planning import Preview
    from burnish.gui.server import Server
    from burnish.gui.stage import Stage
    from burnish.gui.workshop import Workshop
    from burnish.library import Library

    sys.setswitchinterval(1e-3)
    with Library.open(library) as found, Server(found.root, 0) as server:
        workshop = Workshop(server, found)
        bench = workshop.bench
        bench.mount(Part.bundled(MOULD))
        bench.preview = Preview()
        bench.job = SimpleNamespace(box=Mailbox.open(box), outcome=None, said="")
        bench.line, bench.folder, bench.stage = ["polish"], found.root, Stage.RUNNING
        painted: list[float] = []
        repaint = workshop.scene.repaint

        def timed() -> None:
            start = time.perf_counter()
            repaint()
            painted.append(time.perf_counter() - start)

        workshop.scene.repaint = timed  # type: ignore[method-assign]
        thread = threading.Thread(target=workshop.run)
        thread.start()
        while (asked := pipe.recv()) != "end":
            if asked == "url":
                pipe.send(server.url())
            elif asked == "painted":
                assert workshop.scene.paint is not None
                pipe.send((len(workshop.scene.paint.depth), painted[:]))
                painted.clear()
        workshop.stop()
        thread.join()


def view(address: str) -> None:
    """A viewer's process: takes all that the server sends."""
    import viser
    from websockets.sync.client import connect
    from websockets.typing import Origin, Subprotocol

    found = re.fullmatch(r"http://([\d.]+):(\d+)/\?token=(\S+)", address)
    assert found is not None
    host, port, token = found.groups()
    ask = http.client.HTTPConnection(host, int(port), timeout=30)
    ask.request("GET", f"/?token={token}", headers={"Host": f"{host}:{port}"})
    cookie = str(ask.getresponse().getheader("Set-Cookie")).split(";")[0]
    with connect(
        f"ws://{host}:{port}/", additional_headers={"Cookie": cookie}, origin=Origin(f"http://{host}:{port}"),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")], max_size=None,
    ) as socket:  # fmt: skip
        for _ in socket:
            pass


def loop(pipe: Connection, box: str) -> None:
    """The job's process: an arm that is held, its cycles counted whenever it is asked."""
    from burnish.control.joint import ComputedTorque
    from burnish.core import JointReference, State
    from burnish.model.model import Model
    from burnish.polish.cell import HOME
    from burnish.runtime.machine import Mode

    model, law = Model.jaco2(), ComputedTorque.at_frequency(10.0)
    mailbox = Mailbox.open(box)
    reference = JointReference(q=HOME, dq=np.zeros(6), ddq=np.zeros(6))
    law.reset(model.at(State(t=0.0, q=HOME, dq=np.zeros(6))))
    cycles, late, k = 0, 0, 0
    origin = time.monotonic()
    rng = np.random.default_rng(0)
    surface = _surface()
    while True:
        k += 1
        due = origin + k / RATE
        time.sleep(max(0.0, due - time.monotonic()))
        behind = time.monotonic() - due
        q = HOME + 0.1 * np.sin(0.5 * k / RATE + np.arange(6))
        arm = model.at(State(t=k / RATE, q=q, dq=np.zeros(6)))
        tau = law.torque(arm, reference)
        if k % 2 == 0:
            mailbox.post(_glance(time.monotonic(), k / RATE, q, tau, Mode.TORQUE, rng))
        mailbox.mark(surface[k % len(surface)], 10.0, 0.02, 0.05)
        behind = max(behind, time.monotonic() - due)
        cycles, late = cycles + 1, late + (behind > LATE / RATE)
        if behind > 0.1:
            # After a pause the arm does not hurry.
            origin += behind
        if pipe.poll():
            asked = pipe.recv()
            if asked == "end":
                return
            pipe.send((cycles, late))
            cycles, late = 0, 0


def _surface() -> np.ndarray:
    """Points of the mould in rows, as a raster meets them."""
    from burnish.gui.paint import Canvas
    from burnish.surface import Mould

    points = Canvas.of(Mould.load(MOULD)).vertices
    return points[np.lexsort((points[:, 0], np.round(points[:, 1] / 2e-3)))]


def _glance(now: float, t: float, q: Any, tau: Any, mode: Any, rng: np.random.Generator) -> Glance:
    force, tilt = 10.0 + 0.3 * rng.standard_normal(), 0.01 * abs(rng.standard_normal())
    return Glance(
        wall=now, t=t, phase="pass", mode=mode, cause="", stroke=1, strokes=9, done=min(1.0, t / 600.0), q=q,
        dq=np.zeros(6), tau=tau, p=np.zeros(3), R=np.eye(3), v=np.zeros(6), force=force, force_set=10.0, feed=0.02,
        feed_set=0.02, tilt=tilt, late_cycles=0,
    )  # fmt: skip


def cpu(pid: int) -> float:
    """Processor time that a process has used [s]."""
    words = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def bare(pipe: Connection) -> None:
    """A server's process: viser with nothing but a button, as little as a page can be."""
    import viser

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    server.gui.add_button("Stop")
    while pipe.recv() != "end":
        pipe.send(f"http://127.0.0.1:{server.get_port()}")
    server.stop()


def first_views(pipes: dict[str, Connection]) -> dict[str, list[float]]:
    """Time from the address to the controls in a real Chromium, of each page by turns [s]."""
    from playwright.sync_api import sync_playwright

    times: dict[str, list[float]] = {name: [] for name in pipes}
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        for _ in range(VIEWS):
            for name, pipe in pipes.items():
                pipe.send("url")
                page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
                start = time.perf_counter()
                page.goto(pipe.recv())
                page.get_by_role("button", name="Stop").wait_for(timeout=120_000)
                times[name].append(time.perf_counter() - start)
                page.context.close()
        browser.close()
    return times


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="of a block (default: 20)")
    parser.add_argument("--blocks", type=int, default=5, help="with the workshop, and as many without (default: 5)")
    parser.add_argument("--out", type=Path, help="JSON file for the result (default: none)")
    options = parser.parse_args()
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as folder:
        box = Mailbox.create(Path(folder) / "mailbox")
        ours, theirs = context.Pipe()
        job = context.Process(target=loop, args=(theirs, str(box.path)), daemon=True)
        asked, answers = context.Pipe()
        library = str(Path(folder) / "library")
        server = context.Process(target=serve, args=(answers, str(box.path), library), daemon=True)
        job.start()
        server.start()
        assert server.pid is not None
        viewers: list[Any] = []

        def add_viewer() -> None:
            asked.send("url")
            viewers.append(context.Process(target=view, args=(asked.recv(),), daemon=True))
            viewers[-1].start()
            time.sleep(3.0)

        load = os.getloadavg()[0]
        add_viewer()
        asked.send("painted")
        asked.recv()
        before, start = cpu(server.pid), time.monotonic()
        time.sleep(options.seconds)
        share = (cpu(server.pid) - before) / (time.monotonic() - start)
        asked.send("painted")
        vertices, painted = asked.recv()
        for _ in range(VIEWERS - 1):
            add_viewer()
        counts = {"with": [0, 0], "without": [0, 0]}
        for block in range(2 * options.blocks):
            name = "with" if block % 2 == 0 else "without"
            for process in (server, *viewers):
                os.kill(process.pid, signal.SIGCONT if name == "with" else signal.SIGSTOP)
            time.sleep(1.0)
            ours.send("count")
            ours.recv()
            time.sleep(options.seconds)
            ours.send("count")
            cycles, late = ours.recv()
            counts[name][0] += cycles
            counts[name][1] += late
        for process in (server, *viewers):
            os.kill(process.pid, signal.SIGCONT)
        for process in viewers:
            process.terminate()
        views: dict[str, list[float]] = {}
        if CHROMIUM.exists():
            nothing, nowhere = context.Pipe()
            plain = context.Process(target=bare, args=(nowhere,), daemon=True)
            plain.start()
            views = first_views({"workshop": asked, "bare_viser_page": nothing})
            nothing.send("end")
            plain.join(30)
        ours.send("end")
        asked.send("end")
        job.join(30)
        server.join(90)
    late = {name: 100.0 * late / max(1, cycles) for name, (cycles, late) in counts.items()}
    result = {
        "mould_vertices": vertices,
        "server_share_of_a_core_pct": 100.0 * share,
        "colours_ms_median": 1e3 * float(np.median(painted)),
        "colours_ms_p99": 1e3 * float(np.percentile(painted, 99.0)),
        "colour_updates": len(painted),
        "first_view_s": views,
        "viewers": VIEWERS,
        "cycles": {name: count[0] for name, count in counts.items()},
        "late_cycles_pct": late,
        "late_cycles_rise_points": late["with"] - late["without"],
        "load_average_at_start": load,
        "machine": machine(),
    }
    print(json.dumps(result, indent=2))
    if options.out is not None:
        write_json(options.out, result)


if __name__ == "__main__":
    main()
