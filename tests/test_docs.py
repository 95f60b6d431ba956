"""Every Python block of the README and of every page in docs/ runs, in order, in one namespace a page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
BLOCK = re.compile(r"^```python[ \t]*\n(.*?)^```[ \t]*$", re.MULTILINE | re.DOTALL)


def blocks(page: str) -> list[tuple[int, str]]:
    """The Python blocks of a page with the number of the line that each begins in."""
    return [(page.count("\n", 0, match.start(1)), match.group(1)) for match in BLOCK.finditer(page)]


def run(page: str, name: str) -> None:
    """Execute a page's blocks; a failure names the page and its line."""
    namespace: dict[str, object] = {"__name__": name}
    for line, code in blocks(page):
        exec(compile("\n" * line + code, name, "exec"), namespace)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_every_block_of_the_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # what a block writes stays out of the repository
    run(page.read_text(encoding="utf-8"), str(page))


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_every_file_that_the_page_links_to_exists(page: Path) -> None:
    links = LINK.findall(page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert not missing


def test_blocks_of_a_page_share_their_names_and_a_failure_is_noticed_in_its_line() -> None:
    page = "text\n\n```python\nx = 1\n```\n\n```sh\nnot python\n```\n\n```python\nassert x == 2\n```\n"
    with pytest.raises(AssertionError) as caught:
        run(page, "page.md")
    assert caught.traceback[-1].lineno + 1 == 12
