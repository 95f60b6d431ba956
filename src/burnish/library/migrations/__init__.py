"""How the database came to its tables, a step each; shipped, so that a library of an older version goes on."""
