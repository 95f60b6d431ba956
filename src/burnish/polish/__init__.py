"""The work: a path over a mould, the job that rubs along it, and what was polished."""
