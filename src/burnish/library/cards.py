"""A row as a small JSON file beside the files it names: from these cards the database can be built anew."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import MISSING, asdict, fields
from datetime import datetime, timezone
from math import isfinite
from pathlib import Path
from typing import Any, NoReturn, get_type_hints

from burnish.errors import InputError
from burnish.library.rows import KINDS, Row, Scalar, Stored
from burnish.library.storage import read_bounded

FORMAT = "burnish library 1"
"""What a card says first."""
MAX_BYTES = 2**20
"""Largest card that is read [B]."""
FOLDER = "cards"
"""Where they lie below the library's root."""

HINTS: Mapping[str, Mapping[str, Any]] = {word: get_type_hints(kind) for word, kind in KINDS.items()}
"""Types of the fields of each kind."""


def card_path(root: Path, identifier: str) -> Path:
    """Where the card of a row lies."""
    return root / FOLDER / f"{identifier}.json"


def card_of(row: Row) -> dict[str, Any]:
    """A row in plain values."""
    values = asdict(row) | {"files": [asdict(file) for file in row.files]}
    plain = {name: value.isoformat() if isinstance(value, datetime) else value for name, value in values.items()}
    return {"format": FORMAT, "kind": row.KIND} | plain


def card_bytes(row: Row) -> bytes:
    """A card as it is written."""
    return (json.dumps(card_of(row), indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def read_card(path: Path) -> Row:
    """The row of a card in the library.

    Raises:
        InputError: if it is none, or another row's.
    """
    row = parse_card(read_bounded(path, MAX_BYTES), str(path))
    if path.name != f"{row.id}.json":
        raise InputError(f"{path} is the card of the row {row.id}; expected the name {row.id}.json")
    return row


def parse_card(data: bytes, called: str) -> Row:
    """The row of a card, which may be anything.

    Raises:
        InputError: if it is none.
    """
    try:
        card = json.loads(data, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{called} is no card of the library ({str(error)[:100]}); expected JSON") from None
    return from_card(card, called)


def from_card(card: Any, called: str) -> Row:
    """The row of a card's plain values, which may be anything.

    Raises:
        InputError: if they are of another version, or not those of a row.
    """
    word = card.get("kind") if isinstance(card, dict) and card.get("format") == FORMAT else None
    if not isinstance(word, str) or word not in KINDS:
        raise InputError(f'{called} is no card of this version of the library; expected "format": {FORMAT!r}')
    kind = KINDS[word]
    hints = HINTS[word]
    values: dict[str, Any] = {}
    try:
        for field in fields(kind):
            if field.name in card:
                values[field.name] = _READ[hints[field.name]](card[field.name])
            elif field.default is MISSING and field.default_factory is MISSING:
                raise ValueError("it is missing")
        return kind(**values)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{called}: {field.name} cannot be used ({str(error)[:100]}); the card is damaged") from None
    except InputError as error:
        raise InputError(f"{called}: {error}") from None


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("expected a text")
    value.encode()  # What has no form in UTF-8 cannot be stored.
    if "\0" in value:
        raise ValueError("expected a text without the character 0")
    return value


def _whole(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= 2**63:
        raise ValueError("expected a whole number")
    return value


def _number(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not isfinite(value):
        raise ValueError("expected a finite number")
    return float(value)


def _moment(value: Any) -> datetime:
    moment = datetime.fromisoformat(_text(value))
    if moment.tzinfo is None:
        raise ValueError("expected a time with its zone")
    return moment.astimezone(timezone.utc)


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError("expected a list")
    return value


def scalar(value: Any) -> Scalar:
    """A figure as ``metrics.json`` has them.

    Raises:
        ValueError: if it is none.
    """
    if isinstance(value, bool):
        return value
    return _text(value) if isinstance(value, str) else _whole(value) if isinstance(value, int) else _number(value)


def _figures(value: Any) -> dict[str, Scalar]:
    if not isinstance(value, dict):
        raise ValueError("expected names and figures")
    return {_text(name): scalar(figure) for name, figure in value.items()}


def stored_of(value: Any) -> Stored:
    """A file as a card names it.

    Raises:
        ValueError: if it does not.
        InputError: if its name is none.
    """
    if not isinstance(value, dict):
        raise ValueError("expected role, sha256, size and ending")
    role, sha256, ending = (_text(value[name]) for name in ("role", "sha256", "ending"))
    return Stored(role=role, sha256=sha256, size=_whole(value["size"]), ending=ending)


def _refuse(name: str) -> NoReturn:
    """Python's reader takes NaN and Infinity, which JSON does not have."""
    raise ValueError(f"the number {name}")


_READ: Mapping[Any, Callable[[Any], Any]] = {
    str: _text,
    int: _whole,
    float: _number,
    datetime: _moment,
    datetime | None: lambda value: None if value is None else _moment(value),
    tuple[str, ...]: lambda value: tuple(_text(item) for item in _list(value)),
    tuple[float, ...]: lambda value: tuple(_number(item) for item in _list(value)),
    tuple[Stored, ...]: lambda value: tuple(stored_of(item) for item in _list(value)),
    Mapping[str, Scalar]: _figures,
}
"""Type of a field to what reads it."""
