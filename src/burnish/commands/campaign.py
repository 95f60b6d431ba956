"""``burnish campaign``: random tasks with random faults, judged by what the arm did."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from burnish.analysis.atomic import write_atomically
from burnish.campaign.parallel import run_all
from burnish.campaign.report import campaign_html, episode_html, markdown, plot_log
from burnish.campaign.results import Settings, Store, run_episode, save_log
from burnish.campaign.summary import summary, wrong
from burnish.commands.entered import entered
from burnish.commands.options import output_folder, relative
from burnish.commands.progress import Progress
from burnish.errors import InputError

DONE, UNSAFE, INTERRUPTED = 0, 1, 130


def run(options: argparse.Namespace) -> int:
    """Run the episodes that are missing and write ``campaign.json``, ``campaign.md`` and ``report.html``."""
    _check(options)
    folder = output_folder(options.out, "campaign")
    if options.only is not None:
        return _only(options, folder)
    settings = Settings.now(options.seed, nominal=options.nominal)
    store = Store(folder, settings)
    todo = [number for number in range(options.episodes) if number not in store.results]
    done = options.episodes - len(todo)
    with Progress() as progress:
        progress.stage("episodes")
        interrupted = False
        batches = run_all(options.seed, todo, nominal=options.nominal, jobs=options.jobs)
        try:
            for batch in batches:
                store.add(batch)
                done += len(batch)
                progress.update("episodes", done / options.episodes)
        except KeyboardInterrupt:
            interrupted = True
            store.read()
        finally:
            batches.close()
        progress.stage("writing the report")
        chosen = [result for number, result in store.results.items() if number < options.episodes]
        found = summary(chosen, settings)
        plots = {} if interrupted else _worst(options, found, folder)
        command = f"burnish campaign --episodes {options.episodes} --seed {options.seed}"
        told = json.dumps(found | {"interrupted": interrupted}, indent=1, allow_nan=False)
        write_atomically(folder / "campaign.json", (told + "\n").encode())
        write_atomically(folder / "campaign.md", markdown(found, command + " --nominal" * options.nominal).encode())
        html = campaign_html(found, plots, interrupted=interrupted)
        write_atomically(folder / "report.html", html.encode())
    entered(folder)
    _say(found, folder, interrupted=interrupted)
    if interrupted:
        return INTERRUPTED
    return UNSAFE if found["unsafe_samples"] else DONE


def _check(options: argparse.Namespace) -> None:
    for name, value, low, high in (
        ("episodes", options.episodes, 1, 10_000_000),
        ("jobs", options.jobs, 1, 256),
        ("seed", options.seed, 0, 2**32 - 1),
        ("only", options.only, 0, 10_000_000),
    ):
        if value is not None and not low <= value <= high:
            raise InputError(f"{name} {value} is out of range; expected {low} to {high}")


def _only(options: argparse.Namespace, folder: Path) -> int:
    """One episode, with its log and its plot."""
    result, log = run_episode(options.seed, options.only, nominal=options.nominal)
    folder.mkdir(parents=True, exist_ok=True)
    save_log(folder / f"episode-{options.only}.npz", log)
    html = episode_html(log.header, wrong(result), plot_log(log))
    write_atomically(folder / f"episode-{options.only}.html", html.encode())
    print(f"Episode {options.only} of seed {options.seed}: {result.task}, {result.text or 'no fault'}.")
    print(f"The supervisor said: {result.cause or 'nothing'}.")
    print(f"The judge found: {wrong(result) or 'nothing wrong'}.")
    print(f"log and plot: {relative(folder / f'episode-{options.only}.html')}")
    return UNSAFE if result.verdict.unsafe else DONE


def _worst(options: argparse.Namespace, found: Mapping[str, Any], folder: Path) -> dict[int, str]:
    """The worst episodes again, by their seed: their logs are kept, their plots returned."""
    plots = {}
    for each in found["worst"]:
        number = each["episode"]
        _, log = run_episode(options.seed, number, nominal=options.nominal)
        save_log(folder / f"episode-{number}.npz", log)
        plots[number] = plot_log(log)
    return plots


def _say(found: Mapping[str, Any], folder: Path, *, interrupted: bool) -> None:
    """The result in a few lines, for a terminal."""
    print("Interrupted." if interrupted else "Done.")
    print(f"{found['episodes']} episodes, {found['virtual_hours']:.2f} virtual hours: {found['unsafe_samples']} unsafe "
          f"torque samples, {found['late_reactions']} late reactions, {found['still_moving']} still moving, "
          f"{found['overspeed']} too fast, {found['false_trips']} false trips")  # fmt: skip
    print(f"all simulated; report: {relative(folder / 'report.html')}")
