"""Cards: every row comes back from its card as it was, and anything else is refused in one line."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from burnish.errors import InputError
from burnish.library import RecipeRow, Row, RunRow, Stored
from burnish.library.cards import card_bytes, card_of, from_card, parse_card, read_card
from burnish.library.rows import identity

FILE = Stored(role="recipe", sha256="a" * 64, size=3, ending=".toml")
RECIPE = RecipeRow(
    id=identity(RecipeRow, "x"),
    name="a name",
    created=datetime(2026, 1, 2, 3, 4, 5, 678, timezone.utc),
    files=(FILE,),
    tags=("b", "a"),
    notes="two\nlines",
    force=10.0,
    feed=0.02,
    passes=1,
    patterns="raster",
    grit="",
    tool="t" * 64,
)
RUN = RunRow(
    id=identity(RunRow, "x"),
    name="a job",
    created=RECIPE.created,
    binned=RECIPE.created,
    files=(),
    verb="polish",
    mould="dome",
    mould_sha256="",
    arm="honest",
    sensor="wrist",
    ended="done",
    outcome="done",
    duration=3.5,
    folder="/tmp/job",
    metrics={"a": 1, "b": 0.1, "c": "text", "d": True},
)


@pytest.mark.parametrize("row", [RECIPE, RUN])
def test_row_comes_back_from_its_card(row: Row) -> None:
    assert parse_card(card_bytes(row), "card") == row


def test_time_of_another_zone_is_the_same_moment_in_utc() -> None:
    zone = timezone(timedelta(hours=5))
    card = card_of(RECIPE) | {"created": RECIPE.created.astimezone(zone).isoformat()}
    found = from_card(json.loads(json.dumps(card)), "card")
    assert found.created == RECIPE.created
    assert found.created.tzinfo == timezone.utc


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "burnish library 2"}, "version"),
        ({"kind": "rocket"}, "version"),
        ({"id": "../../evil"}, "id"),
        ({"created": "yesterday"}, "created"),
        ({"created": "2026-01-01"}, "created"),
        ({"name": 3}, "name"),
        ({"notes": "a\x00b"}, "notes"),
        ({"notes": "\ud800"}, "notes"),
        ({"force": "10"}, "force"),
        ({"force": True}, "force"),
        ({"passes": 1.5}, "passes"),
        ({"passes": 10**30}, "passes"),
        ({"tags": "felt"}, "tags"),
        ({"tags": [1]}, "tags"),
        ({"files": [{"role": "recipe"}]}, "files"),
        ({"files": [{"role": "recipe", "sha256": "../" * 22, "size": 1, "ending": ".toml"}]}, "64 digits"),
        ({"files": [{"role": "recipe", "sha256": "a" * 64, "size": 1, "ending": "/../../x"}]}, "ending"),
        ({"files": [{"role": "../x", "sha256": "a" * 64, "size": 1, "ending": ".toml"}]}, "ending"),
        ({"files": [{"role": "recipe", "sha256": "a" * 64, "size": -1, "ending": ".toml"}]}, "64 digits"),
    ],
)
def test_card_that_says_what_no_row_can_is_refused(change: dict[str, Any], said: str) -> None:
    card = json.loads(json.dumps(card_of(RECIPE))) | change
    with pytest.raises(InputError, match=said):
        from_card(card, "card")


def test_card_without_a_field_is_refused(tmp_path: Path) -> None:
    card = json.loads(json.dumps(card_of(RECIPE)))
    del card["force"]
    with pytest.raises(InputError, match="force cannot be used"):
        from_card(card, "card")


def test_card_under_another_row_s_name_is_refused(tmp_path: Path) -> None:
    path = tmp_path / f"{RUN.id}.json"
    path.write_bytes(card_bytes(RECIPE))
    with pytest.raises(InputError, match="card of the row"):
        read_card(path)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(card_of(RUN))), JSON)
def test_whatever_stands_in_a_card_is_a_row_that_can_be_written_again_or_refused(name: str, value: Any) -> None:
    try:
        row = parse_card(json.dumps(json.loads(card_bytes(RUN)) | {name: value}).encode(), "card")
    except InputError:
        return
    assert parse_card(card_bytes(row), "card") == row


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_bytes_that_are_no_card_are_refused(content: bytes) -> None:
    with pytest.raises(InputError):
        parse_card(content, "card")


def test_name_that_would_be_empty_is_replaced() -> None:
    assert replace(RECIPE, name=" \n\x00").name == "without a name"
