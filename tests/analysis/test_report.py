from __future__ import annotations

import base64
import os
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from burnish.analysis import Event, write_report
from burnish.analysis.glossary import GLOSSARY, figure
from burnish.analysis.report import SIMULATED, report_html
from burnish.errors import InputError

HOSTILE = "<script>alert('x')</script>\"'&<b onclick=evil()>"
VOID = {"meta", "img", "br", "link"}


class Page(HTMLParser):
    """Collects what a page refers to, the text that it shows, and whether its elements are closed in order."""

    def __init__(self, text):
        super().__init__()
        self.addresses, self.tags, self.open, self.shown = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.addresses += [value for name, value in attrs if name in ("src", "href", "xlink:href", "data", "srcset")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.shown.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.shown).split())


@pytest.fixture
def quick(monkeypatch):
    """A tiny still: these tests are about the page."""
    from burnish.analysis.scene import Scene

    still = Scene.still
    monkeypatch.setattr(Scene, "still", lambda scene: still(scene, 32, 20))


def test_the_page_asks_for_nothing_outside(whole_report, quick):
    text = report_html(whole_report())
    page = Page(text)
    assert page.addresses
    assert all(address.startswith(("data:", "#")) for address in page.addresses)
    assert not any(tag in ("link", "iframe", "object", "base") for tag, _ in page.tags)
    assert not re.search(r"url\((?!#|data:)|@import|fetch\(|XMLHttpRequest|WebSocket", text)
    policy = next(attrs["content"] for tag, attrs in page.tags if attrs.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'")


def test_every_string_from_outside_is_escaped(report, run, quick):
    shape = run["shapes"][0]
    hostile = report(
        title=HOSTILE,
        outcome=f"stopped by the supervisor: {HOSTILE}",
        metrics={"force_rms_N": 0.3, "mould": HOSTILE, HOSTILE: 1.0},
        recipe={HOSTILE: HOSTILE},
        versions={HOSTILE: HOSTILE},
        events=(Event(t=1.5, cause=HOSTILE, detail=HOSTILE),),
        shapes=(type(shape)(name=HOSTILE, vertices=shape.vertices, faces=shape.faces, colour=shape.colour),),
    )
    text = report_html(hostile)
    page = Page(text)
    assert "<script>alert" not in text
    assert not any("onclick" in attrs for _, attrs in page.tags)
    # Title, verdict, metric value and name, recipe twice, versions twice, event twice: shown as they are.
    assert page.text.count("<script>alert('x')</script>") >= 10


def test_phase_names_are_escaped_in_the_plot(report, run):
    series = run["series"]
    names = ("t", "force", "force_set", "tilt", "speed", "feed")
    hostile = type(series)(**{n: getattr(series, n) for n in names}, phases=((0.0, "<b>x</b>"),))
    assert "<b>x</b>" not in report_html(report(series=hostile))


def test_the_headline_says_how_it_ended_and_what_it_reached(report):
    page = Page(report_html(report()))
    assert "Polishing plate Done" in page.text
    assert SIMULATED in page.text
    assert "Force error, RMS 0.32 N Coverage 98.5 % Touch peak 2.4 N" in page.text


def test_a_real_run_is_not_called_simulated(report):
    assert SIMULATED not in report_html(report(simulated=False))


def test_all_metrics_are_listed_with_unit_and_meaning(report):
    metrics = dict.fromkeys(GLOSSARY, 1.5) | {"my_own_figure": 2.25}
    text = Page(report_html(report(metrics=metrics))).text
    for name, meaning in GLOSSARY.items():
        assert meaning.text in text
        assert name in text
    assert "my_own_figure 2.25" in text


def test_the_glossary_knows_the_figures_of_the_file():
    assert set(GLOSSARY) == set(
        "force_set_N force_rms_N force_mean_N force_p99_N touch_peak_N contact_lost_pct tilt_rms_deg tilt_max_deg "
        "feed_rms_pct coverage_pct overpolished_pct removal_cv_pct removal_mean_um path_length_m duration_s "
        "realtime_factor cycles late_cycles supervisor_events seed mould arm sensor rate_Hz "
        "coverage_before_pct removal_cv_before_pct".split()
    )


@pytest.mark.parametrize(
    ("outcome", "colour"),
    [("done", "done"), ("interrupted", "interrupted"), ("stopped by the supervisor: x", "stopped")],
)
def test_the_verdict_has_its_colour(report, outcome, colour):
    assert f'class="verdict {colour}"' in report_html(report(outcome=outcome))


def test_a_run_that_came_to_nothing_still_has_a_report(report):
    bare = report(outcome="interrupted", metrics={}, recipe={}, versions={}, events=())
    page = Page(report_html(bare))
    assert "Interrupted" in page.text
    assert "The supervisor never had to step in" in page.text


def test_events_are_listed(report):
    text = Page(report_html(report(events=(Event(t=12.3456, cause="force", detail="31 N, limit 25 N"),)))).text
    assert "12.346 force 31 N, limit 25 N" in text


def test_the_still_is_a_png_of_the_arm(report, ball, quick, tmp_path):
    page = Page(report_html(report(shapes=(ball(),))))
    source = next(a["src"] for tag, a in page.tags if tag == "img" and "arm" in a["alt"])
    (tmp_path / "still.png").write_bytes(base64.b64decode(source.split(",")[1]))
    assert Image.open(tmp_path / "still.png").size == (32, 20)


def test_a_whole_report_is_small_and_written_whole(whole_report, ball, quick, tmp_path):
    path = tmp_path / "report.html"
    path.write_text("old")
    # 80 000 triangles, more than an arm with its mould.
    write_report(whole_report(shapes=(ball(fineness=6),)), path)
    text = path.read_text()
    assert text.endswith("</html>\n")
    assert len(text) < 4_000_000
    assert list(tmp_path.iterdir()) == [path]
    assert 'class="scene"' in text


def test_a_scene_that_is_too_large_is_a_picture_alone(report, ball, quick, monkeypatch):
    monkeypatch.setattr("burnish.analysis.report.SCENE_FACES", 10)
    text = report_html(report(shapes=(ball(),)))
    assert 'class="scene"' not in text
    assert 'class="hero"' in text


def test_a_folder_that_is_not_there_is_refused(report, tmp_path):
    with pytest.raises(InputError, match="cannot write"):
        write_report(report(), tmp_path / "nowhere" / "report.html")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.3234, "0.323"), (98.76, "98.8"), (123.456, "123.5"), (100.0, "100"), (0.0, "0"), (5e-12, "5e-12"),
        (-0.25, "-0.25"), (12345.6, "12346"), (float("nan"), "–"), (7, "7"), (60000, "60\u202f000"), (True, "yes"),
        ("dome", "dome"), (np.float64(1.25), "1.25"), (np.int64(12), "12"), (np.bool_(False), "no"),
    ],
)  # fmt: skip
def test_figures_are_written_for_people(value, text):
    assert figure(value) == text


@pytest.mark.slow
@pytest.mark.skipif(
    shutil.which("chromium") is None and not os.environ.get("CI"), reason="there is no Chromium; CI has to have one"
)
def test_a_browser_draws_the_scene_without_an_error(report, ball, tmp_path):
    write_report(report(shapes=(ball(colour=(0.9, 0.0, 0.0)),)), tmp_path / "report.html")
    # Software GL on a busy machine may not have drawn in time: then look again, for longer.
    assert any(_balls(tmp_path, seconds) == 2 for seconds in (8, 20, 40))


def _balls(folder, seconds):
    """How many red balls chromium shows of the report: the picture and the scene each have one."""
    flags = "--headless --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic"
    quiet = "--no-first-run --disable-background-networking --disable-component-update --disable-sync"
    shot = folder / f"shot-{seconds}.png"
    result = subprocess.run(
        ["chromium", *flags.split(), *quiet.split(), f"--user-data-dir={folder / 'profile'}",
         "--window-size=900,2600", f"--screenshot={shot}", f"--virtual-time-budget={1000 * seconds}",
         "--enable-logging=stderr", (folder / "report.html").as_uri()],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert "CONSOLE" not in result.stderr
    image = np.asarray(Image.open(shot).convert("RGB")).astype(int)
    rows = np.flatnonzero(((image[..., 0] > 90) & (image[..., 1] < 60)).any(axis=1))
    blocks = np.split(rows, np.flatnonzero(np.diff(rows) > 20) + 1)
    # The swatch of the scene's switch is a few rows of the same red.
    return sum(len(block) > 50 for block in blocks)
