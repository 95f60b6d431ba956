"""The database's tables: one for what all kinds have in common, one for each kind, one for tags, one for files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from datetime import datetime, timezone
from typing import Any

from sqlalchemy import JSON, DateTime, Double, ForeignKey, Index, Text
from sqlalchemy.engine import Dialect
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship
from sqlalchemy.types import BigInteger, TypeDecorator

from burnish.library.rows import KINDS, Row, Stored


class UTC(TypeDecorator[datetime]):
    """A moment: with its zone in Python, plain UTC in the database, the same in every kind of database."""

    impl = DateTime
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Into the database."""
        return None if value is None else value.astimezone(timezone.utc).replace(tzinfo=None)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Out of it."""
        return None if value is None else value.replace(tzinfo=timezone.utc)


class Base(DeclarativeBase):
    """The root of all tables."""

    type_annotation_map = {  # noqa: RUF012
        str: Text,
        datetime: UTC,
        int: BigInteger,
        float: Double,
        Mapping[str, Any]: JSON,
        list[Any]: JSON,
    }


class File(Base):
    """One file of one row; a file that two rows have is stored once."""

    __tablename__ = "files"

    entry_id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    role: Mapped[str] = mapped_column(primary_key=True)
    place: Mapped[int]
    """Order among the row's files."""
    sha256: Mapped[str] = mapped_column(index=True)
    size: Mapped[int]
    ending: Mapped[str]


class Tag(Base):
    """One tag of one row."""

    __tablename__ = "tags"

    entry_id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    word: Mapped[str] = mapped_column(primary_key=True, index=True)


class Entry(Base):
    """A row of any kind."""

    __tablename__ = "entries"

    id: Mapped[str] = mapped_column(primary_key=True)
    kind: Mapped[str]
    name: Mapped[str]
    created: Mapped[datetime]
    binned: Mapped[datetime | None]
    notes: Mapped[str]
    words: Mapped[str]
    """What a search looks through."""
    files: Mapped[list[File]] = relationship(cascade="all, delete-orphan", lazy="selectin", order_by=File.place)
    tags: Mapped[list[Tag]] = relationship(cascade="all, delete-orphan", lazy="selectin", order_by=Tag.word)

    __mapper_args__ = {"polymorphic_on": "kind"}  # noqa: RUF012
    __table_args__ = (Index("ix_entries_list", "kind", "binned", "created", "id"),)


class Mould(Entry):
    """See `MouldRow`."""

    __tablename__ = "moulds"
    __mapper_args__ = {"polymorphic_identity": "mould", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    geometry: Mapped[str] = mapped_column(index=True)
    unit: Mapped[str]
    size: Mapped[list[Any]]
    triangles: Mapped[int]
    warnings: Mapped[list[Any]]


class Tool(Entry):
    """See `ToolRow`."""

    __tablename__ = "tools"
    __mapper_args__ = {"polymorphic_identity": "tool", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    fingerprint: Mapped[str]
    tip_radius: Mapped[float]
    length: Mapped[float]
    stiffness: Mapped[float]
    modulus: Mapped[float]
    friction: Mapped[float]


class Recipe(Entry):
    """See `RecipeRow`."""

    __tablename__ = "recipes"
    __mapper_args__ = {"polymorphic_identity": "recipe", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    force: Mapped[float]
    feed: Mapped[float]
    passes: Mapped[int]
    patterns: Mapped[str]
    grit: Mapped[str]
    tool: Mapped[str]


class Demonstration(Entry):
    """See `DemonstrationRow`."""

    __tablename__ = "demonstrations"
    __mapper_args__ = {"polymorphic_identity": "demonstration", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    mould: Mapped[str]
    mould_sha256: Mapped[str] = mapped_column(index=True)
    arm: Mapped[str]
    device: Mapped[str]
    duration: Mapped[float]
    cycles: Mapped[int]
    contact: Mapped[float]
    force_most: Mapped[float]


class Plan(Entry):
    """See `PlanRow`."""

    __tablename__ = "plans"
    __mapper_args__ = {"polymorphic_identity": "plan", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    mould_sha256: Mapped[str] = mapped_column(index=True)
    strokes: Mapped[int]
    length: Mapped[float]
    duration: Mapped[float]


class Run(Entry):
    """See `RunRow`."""

    __tablename__ = "runs"
    __mapper_args__ = {"polymorphic_identity": "run", "polymorphic_load": "selectin"}  # noqa: RUF012

    id: Mapped[str] = mapped_column(ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)
    verb: Mapped[str]
    mould: Mapped[str] = mapped_column(index=True)
    mould_sha256: Mapped[str] = mapped_column(index=True)
    arm: Mapped[str]
    sensor: Mapped[str]
    ended: Mapped[str]
    outcome: Mapped[str]
    duration: Mapped[float]
    folder: Mapped[str]
    metrics: Mapped[Mapping[str, Any]]


TABLES: Mapping[str, type[Entry]] = {
    "mould": Mould,
    "tool": Tool,
    "recipe": Recipe,
    "demonstration": Demonstration,
    "plan": Plan,
    "run": Run,
}
"""Kind to table."""
_LISTS = ("files", "tags")


def entry_of(row: Row) -> Entry:
    """A row, ready to be stored."""
    entry = TABLES[row.KIND](words=row.words)
    for field in fields(row):
        if field.name not in _LISTS:
            value = getattr(row, field.name)
            setattr(entry, field.name, list(value) if isinstance(value, tuple) else value)
    entry.files = [
        File(role=file.role, place=place, sha256=file.sha256, size=file.size, ending=file.ending)
        for place, file in enumerate(row.files)
    ]
    entry.tags = [Tag(word=word) for word in row.tags]
    return entry


def row_of(entry: Entry) -> Row:
    """What was stored, as a row."""
    kind = KINDS[entry.kind]
    values: dict[str, Any] = {}
    for field in fields(kind):
        if field.name not in _LISTS:
            value = getattr(entry, field.name)
            values[field.name] = tuple(value) if isinstance(value, list) else value
    files = tuple(Stored(role=f.role, sha256=f.sha256, size=f.size, ending=f.ending) for f in entry.files)
    return kind(**values, files=files, tags=tuple(tag.word for tag in entry.tags))
