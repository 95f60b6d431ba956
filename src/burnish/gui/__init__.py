"""The workshop in a browser: one process that shows and asks, and no control."""
