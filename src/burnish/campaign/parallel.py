"""Episodes side by side, in processes of this machine or of a cluster."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Generator, Sequence

from joblib import Parallel, delayed

from burnish.campaign.results import Result, run_batch

BATCH = 8
"""Episodes that a process runs before it reports: a second or two of work."""


def run_all(seed: int, numbers: Sequence[int], *, nominal: bool, jobs: int) -> Generator[list[Result], None, None]:
    """Batches of results, in the order in which they are done.

    No back end is named: one that the caller has set with `joblib.parallel_config`, such as Ray or Dask, is used.
    """
    size = 1 if nominal else BATCH
    batches = [numbers[first : first + size] for first in range(0, len(numbers), size)]
    pool = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=2 * jobs)
    yield from pool(delayed(_run)(os.getpid(), seed, batch, nominal) for batch in batches)


def _run(parent: int, seed: int, batch: Sequence[int], nominal: bool) -> list[Result]:
    """A batch in a process that leaves Ctrl-C to the one that started it."""
    if os.getpid() != parent and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return run_batch(seed, batch, nominal=nominal)
