"""The library's first tables."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

TABLES = ("demonstrations", "files", "moulds", "plans", "recipes", "runs", "tags", "tools")


def upgrade() -> None:
    """Make them."""
    op.create_table(
        "entries",
        sa.Column("id", sa.Text(), primary_key=True),
        _text("kind"),
        _text("name"),
        sa.Column("created", sa.DateTime(), nullable=False),
        sa.Column("binned", sa.DateTime(), nullable=True),
        _text("notes"),
        _text("words"),
    )
    op.create_index("ix_entries_list", "entries", ["kind", "binned", "created", "id"])
    op.create_table(
        "files",
        _entry("entry_id"),
        sa.Column("role", sa.Text(), primary_key=True),
        _whole("place"),
        _text("sha256"),
        _whole("size"),
        _text("ending"),
    )
    op.create_table("tags", _entry("entry_id"), sa.Column("word", sa.Text(), primary_key=True))
    op.create_table(
        "moulds",
        _entry("id"),
        _text("geometry"),
        _text("unit"),
        _json("size"),
        _whole("triangles"),
        _json("warnings"),
    )
    op.create_table(
        "tools",
        _entry("id"),
        _text("fingerprint"),
        *map(_number, ("tip_radius", "length", "stiffness", "modulus", "friction")),
    )
    op.create_table(
        "recipes",
        _entry("id"),
        *map(_number, ("force", "feed")),
        _whole("passes"),
        *map(_text, ("patterns", "grit", "tool")),
    )
    op.create_table(
        "demonstrations",
        _entry("id"),
        *map(_text, ("mould", "mould_sha256", "arm", "device")),
        _number("duration"),
        _whole("cycles"),
        *map(_number, ("contact", "force_most")),
    )
    op.create_table(
        "plans",
        _entry("id"),
        _text("mould_sha256"),
        _whole("strokes"),
        *map(_number, ("length", "duration")),
    )
    op.create_table(
        "runs",
        _entry("id"),
        *map(_text, ("verb", "mould", "mould_sha256", "arm", "sensor", "ended", "outcome")),
        _number("duration"),
        _text("folder"),
        _json("metrics"),
    )
    for table, column in (
        ("files", "sha256"),
        ("tags", "word"),
        ("moulds", "geometry"),
        ("demonstrations", "mould_sha256"),
        ("plans", "mould_sha256"),
        ("runs", "mould"),
        ("runs", "mould_sha256"),
    ):
        op.create_index(f"ix_{table}_{column}", table, [column])


def downgrade() -> None:
    """Drop them."""
    for table in (*TABLES, "entries"):
        op.drop_table(table)


def _entry(name: str) -> sa.Column[str]:
    """The key of a table whose rows belong to those of ``entries``."""
    return sa.Column(name, sa.Text(), sa.ForeignKey("entries.id", ondelete="CASCADE"), primary_key=True)


def _text(name: str) -> sa.Column[str]:
    return sa.Column(name, sa.Text(), nullable=False)


def _number(name: str) -> sa.Column[float]:
    return sa.Column(name, sa.Double(), nullable=False)


def _whole(name: str) -> sa.Column[int]:
    return sa.Column(name, sa.BigInteger(), nullable=False)


def _json(name: str) -> sa.Column[object]:
    return sa.Column(name, sa.JSON(), nullable=False)
