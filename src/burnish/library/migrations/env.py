"""What alembic runs a migration with: the connection that it is given, and the tables to compare with."""

from alembic import context

from burnish.library.tables import Base

connection = context.config.attributes["connection"]
# SQLite cannot alter a table in place: it is written anew ("batch").
context.configure(connection=connection, target_metadata=Base.metadata, render_as_batch=True, compare_type=True)
with context.begin_transaction():
    context.run_migrations()
