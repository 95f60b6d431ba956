"""What the workshop's gate, lease and heart hold: requests without a right, races, and lost commanders.

``python benchmarks/gui_gate.py [requests] [races] [browser] [mailbox] [--rounds N]``; all parts without a word. The
browser is a real Chromium, the job a real ``burnish polish``. Times are of this machine, with whatever else ran on it.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from common import machine, write_json

from burnish.gui.lease import Lease
from burnish.gui.pages import Page
from burnish.gui.process import Process
from burnish.gui.server import Server
from burnish.runtime.machine import Mode
from burnish.runtime.mailbox import Glance, Mailbox

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "gui_gate.json"
CHROMIUM = "/usr/bin/chromium"
FLAGS = (
    "--no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()
RACES, RACERS = 10_000, 8


def answer(port: int, request: bytes) -> bytes:
    """All that the server says to these bytes, up to a megabyte."""
    with socket.create_connection(("127.0.0.1", port), timeout=20.0) as raw:
        raw.sendall(request)
        said = b""
        raw.settimeout(8.0)
        try:
            while len(said) < 1 << 20 and (part := raw.recv(65536)):
                said += part
                if said.startswith(b"HTTP/1.1 101"):
                    break
        except OSError:
            pass
    return said


def request(path: str, headers: list[tuple[str, str]]) -> bytes:
    lines = [f"GET {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers)]
    return ("\r\n".join(lines) + "\r\n\r\n").encode("utf-8", "surrogateescape")


def cookie(server: Server) -> str:
    """The cookie of a browser that was given the address."""
    path = server.url().partition(str(server.port))[2]
    said = answer(server.port, request(path, [("Host", f"127.0.0.1:{server.port}")]))
    found = re.search(rb"Set-Cookie: ([^;]+)", said)
    assert found is not None
    return found[1].decode()


def unauthorised(server: Server, secret: str) -> Iterator[tuple[str, bytes]]:
    """Kind and bytes of requests, none of which has a right to anything."""
    port = server.port
    host = ("Host", f"127.0.0.1:{port}")
    origin = f"http://127.0.0.1:{port}"
    mine = cookie(server)
    upgrade = [
        ("Connection", "Upgrade"),
        ("Upgrade", "websocket"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ("Sec-WebSocket-Protocol", "viser-v1.1.1"),
    ]
    with Server(server.pages._root, port=0) as before:
        stale = f"burnish-{port}=" + cookie(before).partition("=")[2]
    token = server.url().partition("?token=")[2]
    answer(port, request(f"/?token={token}", [host]))
    bad_cookies = ["", "burnish=1", f"burnish-{port}=", stale, mine[:-1], mine + "x", mine.upper(),
                   f"{mine}; {mine}", mine.replace("=", "==", 1)]  # fmt: skip
    paths = ["/", "/index.html", "/report/1", "/heart/x"]
    for path, pair in itertools.product(paths, bad_cookies):
        yield "no or a wrong cookie", request(path, [host, ("Cookie", pair)])
        yield "no or a wrong cookie, socket", request(path, [host, ("Cookie", pair), ("Origin", origin), *upgrade])
    for path, word in itertools.product(
        paths, [token, "", "x", token[:-1], token + "A", "%00", "' or 1=1 --".replace(" ", "+")]
    ):
        yield "used or wrong token", request(f"{path}?token={word}", [host])
    hosts = ["evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1.evil.example:{port}", f"[::1]:{port}",
             f"0.0.0.0:{port}", "", f"127.0.0.1:{port + 1}", f"LOCALHOST.:{port}", f"x@127.0.0.1:{port}"]  # fmt: skip
    for path, name in itertools.product(paths, hosts):
        yield "wrong Host", request(path, [("Host", name), ("Cookie", mine)])
        yield (
            "wrong Host, socket",
            request(path, [("Host", name), ("Cookie", mine), ("Origin", f"http://{name}"), *upgrade]),
        )
    origins = ["null", "http://evil.example", "https://evil.example", f"https://127.0.0.1:{port}", "file://",
               f"http://127.0.0.1:{port}.evil.example", f"http://localhost:{port}", f"{origin}/", ""]  # fmt: skip
    for path, name in itertools.product(paths, origins):
        yield "wrong Origin", request(path, [host, ("Cookie", mine), ("Origin", name)])
        yield "wrong Origin, socket", request(path, [host, ("Cookie", mine), ("Origin", name), *upgrade])
    for path, site in itertools.product(paths, ["cross-site", "same-site", "x"]):
        yield "another page's request", request(path, [host, ("Cookie", mine), ("Sec-Fetch-Site", site)])
    for path in paths:
        yield "socket without Origin", request(path, [host, ("Cookie", mine), *upgrade])
    ups = ["..", "%2e%2e", "..%2f", "..\\", "%2e%2e%5c", "....//", "%c0%ae%c0%ae", "..;", ".%2e", "..%00"]
    ends = ["etc/passwd", secret.lstrip("/"), "proc/self/environ", "secret.html"]
    for up, depth, end in itertools.product(ups, (1, 3, 12), ends):
        climbed = "/".join([up] * depth)
        yield "traversal", request(f"/{climbed}/{end}", [host, ("Cookie", mine)])
        yield "traversal", request(f"/report/{climbed}/{end}", [host, ("Cookie", mine)])
    for name in ("out", "link", "folder", "none", "1/../out", "1%00", "1.html"):
        yield "page outside the root", request(f"/report/{name}", [host, ("Cookie", mine)])
    for size in (9_000, 70_000, 2_000_000):
        yield "oversized", request("/" + "a" * size, [host, ("Cookie", mine)])
        yield "oversized", request("/", [host, ("Cookie", mine), ("X-Large", "a" * size)])
        yield "oversized", request("/", [host, ("Cookie", mine), *[(f"X-{k}", "a") for k in range(size // 40)]])
        yield "oversized", request("/", [host, ("Cookie", mine), ("Content-Length", str(size))]) + b"a" * size
    for method in ("POST", "PUT", "HEAD", "OPTIONS", "CONNECT", "TRACE", "get", "PRI"):
        yield "method", request("/", [host, ("Cookie", mine)]).replace(b"GET", method.encode(), 1)


def requests(folder: Path) -> dict[str, Any]:
    """No unauthorised request gets more than a refusal."""
    root = folder / "root"
    root.mkdir()
    (root / "report.html").write_text("the report")
    (folder / "secret.html").write_text("the secret")
    (root / "link.html").symlink_to(folder / "secret.html")
    files = {"1": root / "report.html", "out": root / ".." / "secret.html", "link": root / "link.html", "folder": root}
    counts: dict[str, int] = {}
    accepted: list[tuple[str, bytes]] = []
    leaked, statuses = 0, dict[str, int]()
    with Server(root, port=0) as server:
        server.pages.add("report", lambda name: Page(path=files[name]) if name in files else None)
        named = [("Host", f"127.0.0.1:{server.port}"), ("Cookie", cookie(server))]
        assert b"the report" in answer(server.port, request("/report/1", named)), "whoever has a right is refused too"
        tried = list(unauthorised(server, str(folder / "secret.html")))
        for kind, words in tried:
            counts[kind] = counts.get(kind, 0) + 1
            said = answer(server.port, words)
            status = said[9:12].decode("ascii", "replace") or "closed"
            statuses[status] = statuses.get(status, 0) + 1
            if status in ("200", "101", "303"):
                accepted.append((kind, words[:200]))
            leaked += any(mark in said for mark in (b"the secret", b"the report", b"root:x:", b"viser", b"PATH="))
    total = sum(counts.values())
    print(f"requests: {total}, accepted {len(accepted)}, answers with a file in them {leaked}; {statuses}")
    for kind, words in accepted:
        print(f"  accepted: {kind}: {words!r}")
    return {"requests": total, "accepted": len(accepted), "leaked": leaked, "by_kind": counts, "by_status": statuses}


def interrupted() -> float:
    """A clock that lets the other threads go first, so that whatever is not locked goes wrong."""
    time.sleep(1e-5)
    return time.monotonic()


def races() -> dict[str, Any]:
    """Of several who take command at the same moment exactly one has it."""
    lease = Lease(term=60.0, clock=interrupted)
    winners = np.zeros(RACES, np.int64)
    start, done = threading.Barrier(RACERS), threading.Barrier(RACERS)

    def racer(who: int) -> None:
        for race in range(RACES):
            start.wait()
            won = lease.take(who) is not None
            if won:
                winners[race] += 1
            done.wait()
            if won:
                lease.leave(who)

    began = time.perf_counter()
    threads = [threading.Thread(target=racer, args=(who,)) for who in range(RACERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    wrong = int((winners != 1).sum())
    print(f"races: {RACES} of {RACERS} threads in {time.perf_counter() - began:.0f} s, not exactly one: {wrong}")
    return {"races": RACES, "threads": RACERS, "not_exactly_one": wrong}


@contextmanager
def commander(folder: Path) -> Iterator[tuple[Server, Any, Any, int]]:
    """A server, a Chromium, its page, and the client that has the command."""
    from playwright.sync_api import sync_playwright

    with Server(folder, port=0) as server, sync_playwright() as playwright:
        clients: list[int] = []
        server.viser.on_client_connect(lambda client: clients.append(client.client_id))
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page()
        page.goto(server.url())
        until = time.monotonic() + 60.0
        while time.monotonic() < until and (not clients or server.take(clients[-1]) is None):
            page.wait_for_timeout(50)
        assert server.lease.grant is not None, "the page never had a heart"
        try:
            yield server, browser, page, clients[-1]
        finally:
            if browser.is_connected():
                browser.close()


def children(pid: int) -> list[int]:
    """All processes that this one has started, and theirs."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            child = int(path.parent.name)
            found += [child, *children(child)]
    return found


def chromiums() -> list[int]:
    """The processes of the Chromium that this program has started."""
    ours = children(os.getpid())
    return [pid for pid in ours if b"chromium" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def each(number: int) -> Callable[[Any], Callable[[], object]]:
    """Makes ready to send all processes of the browser a signal: to find them takes longer than the loss may."""

    def ready(page: Any) -> Callable[[], object]:
        pids = chromiums()

        def send() -> None:
            for pid in pids:
                os.kill(pid, number)

        return send

    return ready


def browser(folder: Path, rounds: int) -> dict[str, Any]:
    """From the loss of the commander in the middle of a contact to the supervisor's hold; then the job goes on."""
    ways: dict[str, Callable[[Any], Callable[[], object]]] = {
        "tab closed": lambda page: page.close,
        "browser killed": each(signal.SIGKILL),
        # Sockets stay open and nothing comes: what a cut cable looks like to a server.
        "network cut": each(signal.SIGSTOP),
        "page left": lambda page: partial(page.goto, "about:blank"),
    }
    results: dict[str, Any] = {}
    for way, losing in ways.items():
        held = []
        resumed = 0
        for turn in range(rounds):
            out = folder / f"{way.replace(' ', '-')}-{turn}"
            with commander(folder) as (server, _, page, client):
                job = server.start(["polish", "--mould", "plate", "--pace", "2", "--out", str(out)], client)
                mid_contact(job, lambda: page.wait_for_timeout(100))
                stopped = chromiums() if way == "network cut" else []
                lose = losing(page)
                lost = time.monotonic()
                waiting = threading.Thread(target=lambda: held.append(hold(job, lost)))  # noqa: B023
                waiting.start()
                lose()
                waiting.join()
                for pid in stopped:
                    os.kill(pid, signal.SIGKILL)
                code = job.wait()
                assert code == 3, f"the job ended with {code}: {job.said}"
            # A journal is a journal: the first job of each way is gone on with.
            resumed += turn > 0 or goes_on(out)
        results[way] = {"rounds": rounds, "hold_after_ms": [round(1e3 * t) for t in held], "resumed": resumed == rounds}
        print(f"{way}: HOLD after {', '.join(f'{1e3 * t:.0f}' for t in held)} ms; resumed {resumed} of {rounds}")
    return results


def mid_contact(job: Process, rest: Callable[[], object]) -> float:
    """Wait until the job presses and rubs; the time of that."""
    until = time.monotonic() + 300.0
    while time.monotonic() < until and job.outcome is None:
        rest()
        seen = job.box.latest()
        if seen is not None and seen.phase == "pass" and seen.done > 0.01 and seen.force > 5.0:
            return seen.wall
    raise RuntimeError(f"the job never got to work: {job.said}")


def hold(job: Process, since: float) -> float:
    """Wait for the supervisor's hold; the wall time from ``since`` to the cycle that was held [s]."""
    until = since + 20.0
    while time.monotonic() < until:
        seen = job.box.latest()
        if seen is not None and seen.mode is Mode.HOLD:
            return seen.wall - since
        time.sleep(0.001)
    return float("nan")


def goes_on(out: Path) -> bool:
    """Whether the job goes on where it was; it is stopped again once it works."""
    from burnish.gui.lease import Grant

    grant = Grant(number=1, who=1)
    job = Process(["polish", "--resume", str(out)], grant)

    def wait() -> None:
        job.beat(grant, time.monotonic())
        time.sleep(0.01)

    mid_contact(job, wait)
    job.stop()
    while job.outcome is None:
        job.beat(grant, time.monotonic())
        time.sleep(0.02)
    return job.close() == 130 and bool(list(out.glob("run-*.mcap")))


def mailbox(folder: Path) -> dict[str, Any]:
    """What the loop pays."""
    box = Mailbox.create(folder / "box")
    ones = np.ones(6)
    shown = Glance(
        wall=0.0, t=0.0, phase="pass", mode=Mode.TORQUE, cause="", stroke=1, strokes=3, done=0.5, q=ones, dq=ones,
        tau=ones, p=ones[:3], R=np.eye(3), v=ones, force=10.0, force_set=10.0, feed=0.02, feed_set=0.02, tilt=0.0,
        late_cycles=0,
    )  # fmt: skip
    calls: dict[str, Callable[[], object]] = {
        "post": lambda: box.post(shown),
        "mark": lambda: box.mark(ones[:3], 10.0, 0.02, 0.05),
        "order and beat": lambda: (box.wanted, box.commanded),
    }
    results = {}
    for name, call in calls.items():
        times = []
        for _ in range(20_000):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
        median, most = 1e6 * float(np.median(times)), 1e6 * float(np.percentile(times, 99))
        results[name] = {"median_us": round(median, 2), "p99_us": round(most, 2)}
        print(f"{name}: {median:.1f} µs, 99 % within {most:.1f} µs")
    return results


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("parts", nargs="*", choices=["requests", "races", "browser", "mailbox", []])
    options.add_argument("--rounds", type=int, default=3, help="of each way to lose the commander (default: 3)")
    asked = options.parse_args()
    parts = asked.parts or ["mailbox", "requests", "races", "browser"]
    results: dict[str, Any] = {"machine": machine()}
    with tempfile.TemporaryDirectory(prefix="burnish-gate-") as name:
        folder = Path(name)
        if "mailbox" in parts:
            results["mailbox"] = mailbox(folder)
        if "requests" in parts:
            results["requests"] = requests(folder)
        if "races" in parts:
            results["races"] = races()
        if "browser" in parts:
            results["browser"] = browser(folder, asked.rounds)
    if not asked.parts:
        write_json(RESULTS, results)


if __name__ == "__main__":
    main()
