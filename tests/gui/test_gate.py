"""Who gets in, and what nobody gets."""

from __future__ import annotations

from pathlib import Path

import pytest
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from burnish.gui import gate as gates
from burnish.gui.gate import Gate, cookie_name
from burnish.gui.pages import LARGEST, Page, Pages

PORT = 8123
OWN = {"Host": f"127.0.0.1:{PORT}"}


async def hearts(connection: object, key: str) -> None:
    raise AssertionError("asked only of a socket")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "root").mkdir()
    (tmp_path / "root" / "report.html").write_text("<p>a report</p>")
    (tmp_path / "root" / "run.mcap").write_bytes(b"\x89MCAP")
    (tmp_path / "secret.html").write_text("secret")
    (tmp_path / "root" / "link.html").symlink_to(tmp_path / "secret.html")
    return tmp_path / "root"


@pytest.fixture
def gate(root: Path) -> Gate:
    pages = Pages(root)
    files = {
        "1": Page(path=root / "report.html"),
        "2": Page(path=root / "run.mcap"),
        "3": Page(path=root / "report.html", save_as="über.html"),
        "out": Page(path=root / ".." / "secret.html"),
        "link": Page(path=root / "link.html"),
        "folder": Page(path=root),
        "gone": Page(path=root / "gone.html"),
    }
    pages.add("report", files.get)
    return Gate(pages, hearts)


def asked(gate: Gate, path: str = "/", *pairs: tuple[str, str], **others: str) -> Response | None:
    """The gate's word on a request with these headers."""
    headers = Headers(OWN | {name.replace("_", "-"): value for name, value in others.items()})
    for name, value in pairs:
        headers[name] = value
    return gate.admit(Request(path, headers), PORT)


def status(answer: Response | None) -> int | None:
    return None if answer is None else answer.status_code


def cookie(gate: Gate) -> str:
    """The cookie that a token is exchanged for."""
    answer = asked(gate, f"/?token={gate.token()}")
    assert answer is not None
    assert answer.status_code == 303
    assert answer.headers["Location"] == "/"
    pair, *flags = answer.headers["Set-Cookie"].split("; ")
    assert set(flags) == {"HttpOnly", "SameSite=Strict", "Path=/"}
    name, _, value = pair.partition("=")
    assert name == cookie_name(PORT)
    assert len(value) >= 256 // 6
    return pair


def test_token_gives_a_cookie_that_lets_in(gate: Gate) -> None:
    pair = cookie(gate)
    assert asked(gate, "/", Cookie=pair) is None
    assert asked(gate, "/", Cookie=f"other=1; {pair}") is None
    assert asked(gate, "/", Cookie=pair, Upgrade="websocket", Origin=f"http://127.0.0.1:{PORT}") is None
    assert asked(gate, "/heart/abc", Cookie=pair, Upgrade="websocket", Origin=f"http://127.0.0.1:{PORT}") is None


def test_token_works_once_and_not_for_ever(gate: Gate, monkeypatch: pytest.MonkeyPatch) -> None:
    token = gate.token()
    assert status(asked(gate, f"/?token={token}")) == 303
    assert status(asked(gate, f"/?token={token}")) == 401
    late = gate.token()
    now = gates.time.monotonic()
    monkeypatch.setattr(gates.time, "monotonic", lambda: now + gates.VALID + 1.0)
    assert status(asked(gate, f"/?token={late}")) == 401


def test_token_survives_a_browser_that_only_looks_ahead(gate: Gate) -> None:
    token = gate.token()
    assert status(asked(gate, f"/?token={token}", Sec_Purpose="prefetch")) == 403
    assert status(asked(gate, f"/?token={token}", Sec_Fetch_Site="cross-site")) == 403
    assert status(asked(gate, f"/?token={token}", Sec_Fetch_Site="none")) == 303


@pytest.mark.parametrize("given", ["", "x", "burnish-8123=", "burnish-8123=x", "burnish-8123=é", "burnish-8123"])
def test_without_a_cookie_of_this_run_nothing_is_there(gate: Gate, given: str) -> None:
    cookie(gate)
    for path in ("/", "/index.html", "/report/1", "/nothing"):
        assert status(asked(gate, path, Cookie=given)) == 401
        assert status(asked(gate, path)) == 401


def test_cookie_of_another_run_or_another_server_is_refused(gate: Gate, root: Path) -> None:
    other = Gate(Pages(root), hearts)
    pair = cookie(other)
    assert status(asked(gate, "/", Cookie=pair)) == 401
    mine = cookie(gate)
    assert status(asked(gate, "/", Cookie=mine.replace(str(PORT), "9000"))) == 401
    # Two of one name: somebody has put one beside ours.
    assert status(asked(gate, "/", Cookie=f"{mine}; {mine}")) == 401
    assert status(asked(gate, "/", ("Cookie", mine), ("Cookie", mine))) == 401


@pytest.mark.parametrize(
    "host",
    ["", "evil.example", f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:80", f"127.0.0.1.evil.example:{PORT}",
     f"0.0.0.0:{PORT}", f"[::1]:{PORT}", f"localhost.:{PORT}", f"user@127.0.0.1:{PORT}"],
)  # fmt: skip
def test_host_has_to_be_this_server(gate: Gate, host: str) -> None:
    pair = cookie(gate)
    assert status(gate.admit(Request("/", Headers({"Host": host, "Cookie": pair})), PORT)) == 403


def test_host_is_said_once(gate: Gate) -> None:
    pair = cookie(gate)
    assert status(gate.admit(Request("/", Headers({"Cookie": pair})), PORT)) == 403
    assert status(asked(gate, "/", ("Host", OWN["Host"]), Cookie=pair)) == 403
    assert gate.admit(Request("/", Headers({"Host": f"localhost:{PORT}", "Cookie": pair})), PORT) is None


@pytest.mark.parametrize(
    "origin",
    ["null", "", "http://evil.example", f"https://127.0.0.1:{PORT}", "http://127.0.0.1", f"http://localhost:{PORT}",
     f"http://127.0.0.1:{PORT}.evil.example", "file://", f"http://127.0.0.1:{PORT}/"],
)  # fmt: skip
def test_other_origins_are_refused_with_the_right_cookie(gate: Gate, origin: str) -> None:
    pair = cookie(gate)
    assert status(asked(gate, "/", Cookie=pair, Origin=origin)) == 403
    assert status(asked(gate, "/", Cookie=pair, Origin=origin, Upgrade="websocket")) == 403


def test_socket_has_to_say_its_origin(gate: Gate) -> None:
    assert status(asked(gate, "/", Cookie=cookie(gate), Upgrade="websocket")) == 403
    assert status(asked(gate, "/", Cookie=cookie(gate), Upgrade="WebSocket")) == 403


@pytest.mark.parametrize("site", ["cross-site", "same-site", ""])
def test_request_that_another_page_makes_is_refused(gate: Gate, site: str) -> None:
    assert status(asked(gate, "/", Cookie=cookie(gate), Sec_Fetch_Site=site)) == 403


@pytest.mark.parametrize(
    "path",
    ["/../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/secret.html", "//etc/passwd", "/report/../1", "/report/1/..",
     "/report/%31", "/report/", "/report/1/", "/report/1.html", "/report/" + "1" * 65, "/other/1", "/report/out",
     "/report/link", "/report/folder", "/report/gone", "/report/é", "/report/1\n", "\\..\\secret.html", "", "*",
     "http://evil.example/", "/index.html/../../x", "/report/\x00"],
)  # fmt: skip
def test_no_path_leads_outside(gate: Gate, path: str) -> None:
    answer = asked(gate, path, Cookie=cookie(gate))
    assert answer is not None
    assert answer.status_code == 404
    assert b"secret" not in answer.body


def test_report_is_shown_without_any_right(gate: Gate) -> None:
    answer = asked(gate, "/report/1?tab=2", Cookie=cookie(gate))
    assert answer is not None
    assert answer.status_code == 200
    assert answer.body == b"<p>a report</p>"
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    policy = answer.headers["Content-Security-Policy"]
    assert policy.startswith("sandbox ")
    assert "allow-same-origin" not in policy
    assert "default-src 'none'" in policy
    assert "Content-Disposition" not in answer.headers


def test_what_a_browser_cannot_show_is_stored(gate: Gate) -> None:
    pair = cookie(gate)
    run, renamed = asked(gate, "/report/2", Cookie=pair), asked(gate, "/report/3", Cookie=pair)
    assert run is not None
    assert renamed is not None
    assert run.headers["Content-Disposition"] == "attachment; filename*=UTF-8''run.mcap"
    assert run.headers["Content-Type"] == "application/octet-stream"
    assert renamed.headers["Content-Disposition"] == "attachment; filename*=UTF-8''%C3%BCber.html"


def test_page_that_is_too_large_is_not_read(gate: Gate, root: Path) -> None:
    with (root / "report.html").open("wb") as file:
        file.truncate(LARGEST + 1)
    assert status(asked(gate, "/report/1", Cookie=cookie(gate))) == 404


def test_every_refusal_keeps_a_browser_from_guessing(gate: Gate) -> None:
    for answer in (asked(gate), asked(gate, "/", Origin="null"), asked(gate, "/x", Cookie=cookie(gate))):
        assert answer is not None
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert answer.headers["Cache-Control"] == "no-store"
        assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
