"""``burnish reproduce``: the sources' experiments, beside ours."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import signal
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from burnish.analysis.atomic import write_atomically
from burnish.commands.options import output_folder, relative
from burnish.commands.progress import Progress
from burnish.errors import InputError, SimulationError
from burnish.experiments.catalogue import experiment, experiments
from burnish.trials.experiment import Experiment, Trial
from burnish.trials.outcome import Outcome, outcome
from burnish.trials.plots import errors_svg
from burnish.trials.record import Record
from burnish.trials.report import reproduction_html
from burnish.trials.run import run as run_trial
from burnish.trials.tables import as_markdown, score

DONE, INTERRUPTED = 0, 130


def run(options: argparse.Namespace) -> int:
    """Run the experiments and write ``results.json``, ``results.md`` and ``report.html``; or list them."""
    known = experiments()
    if options.list:
        for name, each in known.items():
            print(f"{name:<24} {each.title}")
        return DONE
    unknown = [name for name in options.names if name not in known]
    if unknown:
        raise InputError(f"no experiment is called {', '.join(unknown)}; there are {', '.join(known)}")
    if not 1 <= options.jobs <= 64:
        raise InputError(f"jobs {options.jobs} is out of range; expected 1 to 64 processes")
    folder = output_folder(options.out, "reproduce")
    asked = {name: known[name] for name in dict.fromkeys(options.names)} or known
    work = Reproduction(experiments=asked, folder=folder)
    folder.mkdir(parents=True, exist_ok=True)
    with Progress() as progress:
        interrupted = work.run(options.jobs, progress)
        progress.stage("writing the report")
        command = " ".join(["burnish reproduce", *options.names])
        write_atomically(folder / "results.md", as_markdown(work.outcomes, command).encode())
        html = reproduction_html(work.outcomes, work.plots, interrupted=interrupted)
        write_atomically(folder / "report.html", html.encode())
    _say(work.outcomes, folder, interrupted=interrupted)
    return INTERRUPTED if interrupted else DONE


@dataclass(kw_only=True)
class Reproduction:
    """Experiments under way: their trials run in other processes, and are judged as soon as all of one are there."""

    experiments: Mapping[str, Experiment]
    """What to run."""
    folder: Path
    """Where ``results.json`` grows."""
    plots: dict[str, str] = field(default_factory=dict)
    """Name of an experiment to its ``<svg>``."""
    _trials: dict[str, Sequence[Trial]] = field(default_factory=dict, init=False)
    _records: dict[str, dict[str, Record]] = field(default_factory=dict, init=False)
    _outcomes: dict[str, Outcome] = field(default_factory=dict, init=False)

    @property
    def outcomes(self) -> list[Outcome]:
        """What has come out so far, in the order in which it was asked for."""
        return [self._outcomes[name] for name in self.experiments if name in self._outcomes]

    def run(self, jobs: int, progress: Progress) -> bool:
        """Run all trials; returns whether that was interrupted, with what was done until then kept."""
        progress.stage("preparing")
        self._trials = {name: each.trials() for name, each in self.experiments.items()}
        self._records = {name: {} for name in self._trials}
        work = {(name, i): _work(t) for name, trials in self._trials.items() for i, t in enumerate(trials)}
        done = 0.0
        try:
            with _pool(jobs) as pool:
                futures: dict[Future[Record], tuple[str, int]] = {pool.submit(run_task, *task): task for task in work}
                for future in as_completed(futures):
                    name, i = futures.pop(future)
                    self._take(name, i, future.result())
                    done += work[name, i]
                    progress.update(name, done / sum(work.values()))
        except KeyboardInterrupt:
            for name in self._trials:
                if self._records[name]:
                    self._judge(name)
            return True
        except BrokenProcessPool as error:
            raise SimulationError("a process that ran a trial was ended from outside, or for want of memory") from error
        return False

    def _take(self, name: str, i: int, record: Record) -> None:
        """File the record of a trial; the last one of an experiment has it judged."""
        # It came from another process without its model.
        record.model = self._trials[name][i].model
        self._records[name][self._trials[name][i].name] = record
        if len(self._records[name]) == len(self._trials[name]):
            self._judge(name)

    def _judge(self, name: str) -> None:
        """Figures, findings and plot; then the records may go."""
        trials, records = self._trials[name], self._records[name]
        self._outcomes[name] = outcome(name, self.experiments[name], trials, records)
        self.plots[name] = errors_svg(name, trials, records)
        self._records[name] = {}
        content = json.dumps([each.as_json() for each in self.outcomes], indent=1, allow_nan=False)
        write_atomically(self.folder / "results.json", content.encode())


def run_task(name: str, i: int) -> Record:
    """The record of the i-th trial of an experiment; what a process of the pool does."""
    return run_trial(_trials(name)[i])


@cache
def _trials(name: str) -> Sequence[Trial]:
    """The trials of an experiment, made once in a process: each of them is run in one process only."""
    return experiment(name).trials()


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that have nothing of this one's threads, leave Ctrl-C to it, and end at once when it is interrupted."""
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_ignore_interrupt)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown()


def _ignore_interrupt() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(trial: Trial) -> float:
    """Cycles and physics of a trial, in cycles: a second of physics costs as much as about 500."""
    rate = trial.arm.rate if trial.rate is None else trial.rate
    return trial.duration * (rate + 500.0)


def _say(outcomes: Sequence[Outcome], folder: Path, *, interrupted: bool) -> None:
    """The result in a few lines, for a terminal."""
    print("Interrupted." if interrupted else "Done.")
    for each in outcomes:
        print(f"{each.name:<24} {score(each.findings):>7} claims hold: {each.title}")
    print(f"all simulated; report: {relative(folder / 'report.html')}")
