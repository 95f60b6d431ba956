"""What made a run, as text and as a fingerprint: laws, limits and tools are frozen data, so both are exact."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass
from math import isfinite
from typing import Any

import numpy as np


def described(thing: Any) -> str:
    """A dataclass as JSON with its type's name and all it was made from; every number with all its digits."""
    return json.dumps(_plain(thing), ensure_ascii=False, allow_nan=False)


def fingerprint(thing: Any) -> str:
    """SHA-256 of that text."""
    return hashlib.sha256(described(thing).encode()).hexdigest()


def _plain(value: Any) -> Any:
    """The same in what JSON has."""
    if is_dataclass(value) and not isinstance(value, type):
        made_of = {field.name: _plain(getattr(value, field.name)) for field in fields(value) if field.init}
        return {"type": type(value).__name__} | made_of
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        # JSON has no such numbers.
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    # A function, an error of orientation for instance, is what it is called.
    return getattr(value, "__qualname__", type(value).__name__)
