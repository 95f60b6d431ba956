"""How fast a library of 10,000 runs answers, and what processes that are killed at any moment leave of it.

    python benchmarks/library.py --rows 10000 --kills 500 --seed 1 --out benchmarks/results/library.json
    python benchmarks/library.py --kills 500 --database postgresql://user@host/empty --out postgresql.json

**Kills.** Two processes at a time enter recipes, rename, tag, put into the bin, empty it, write backups and build the
database anew; at a random moment both get SIGKILL. Each says in a pipe what it is about to do and what is done. Every
row that was said to be done has to be there as it was said, and `Library.check` has to find nothing. In every fiftieth
round the database is overwritten with noise and has to come back from the files.

**Speed.** The median and the worst of 30 calls each, by the clock on the wall, of what a person waits for; beside it
how many processes wanted a processor at the same time (the load average), ours among them.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import select
import shutil
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta, timezone
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

from common import machine, write_json
from sqlalchemy import text

from burnish.errors import BurnishError
from burnish.library import Library, RecipeRow, Row, RunRow, Stored
from burnish.library.cards import card_bytes, card_path
from burnish.library.rows import identity
from burnish.polish.recipe import Recipe
from burnish.polish.recipe_file import as_toml

CALLS = 30
FRESH = 50
"""Rounds after which a new library is begun, so that checking all of it stays quick."""
LONGEST = 0.5
"""Of a round, from the first row that was entered to the kill [s]."""
EARLY = 0.2
"""Share of the rounds that end before: while a library is made or opened."""
WORDS = "felt paste door bonnet left right wet dry coarse fine hinge lid frame edge fillet pocket corner lens".split()

State = dict[str, Any] | None
"""Name, tags and whether it lies in the bin; None where there is no row."""


# Kills.


@dataclass(kw_only=True)
class Expected:
    """What the processes said of their rows."""

    done: dict[str, State] = field(default_factory=dict)
    """How each row was said to be."""
    trying: dict[str, list[State]] = field(default_factory=dict)
    """What was about to become of it when its process was killed."""
    acknowledged: int = 0
    trouble: list[str] = field(default_factory=list)

    def hear(self, said: bytes) -> None:
        """All whole lines of one process; what it was about to do last may have happened or not."""
        trying: dict[str, State] = {}
        for line in said.split(b"\n")[:-1]:
            told = json.loads(line)
            if "error" in told:
                self.trouble.append(told["error"])
            elif told["done"]:
                self.done |= told["rows"]
                self.acknowledged += 1
                trying = {}
            else:
                trying = told["rows"]
        for identifier, state in trying.items():
            self.trying.setdefault(identifier, []).append(state)

    def settle(self, found: dict[str, State]) -> list[str]:
        """Ids of the rows that are not as they may be. From then on they are expected as they were found."""
        lost = []
        for identifier in self.done.keys() | self.trying.keys():
            allowed = [self.done.get(identifier), *self.trying.get(identifier, [])]
            if any(state is not None and state["binned"] for state in allowed):
                allowed.append(None)  # Anybody may have emptied the bin.
            if found.get(identifier) not in allowed:
                lost.append(identifier)
        self.done, self.trying = dict(found), {}
        return lost


def state_of(row: Row) -> State:
    return {"name": row.name, "tags": list(row.tags), "binned": row.binned is not None}


def work(folder: Path, url: str | None, seed: int, say: Callable[[dict[str, Any]], None]) -> None:
    """What one of the processes does until it is killed."""
    rng = random.Random(seed)
    recipe, archive = folder / f"recipe-{seed}.toml", folder / f"backup-{seed}.zip"
    rows: list[Row] = []

    def does(identifier: str, will: State, edit: Callable[[], Row]) -> Row:
        say({"done": False, "rows": {identifier: will}})
        row = edit()
        say({"done": True, "rows": {row.id: state_of(row)}})
        return row

    with Library.open(folder / "library", url) as library:
        while True:
            choice, word = rng.random(), rng.choice(WORDS)
            if not rows or choice < 0.4:
                recipe.write_text(f"# {rng.random()}\n{as_toml(Recipe(force=rng.uniform(2.0, 20.0)))}")
                # The id follows from the file.
                identifier = identity(RecipeRow, hashlib.sha256(recipe.read_bytes()).hexdigest())
                will: State = {"name": word, "tags": [], "binned": False}
                rows.append(does(identifier, will, partial(library.add_recipe, recipe, name=word)))
                continue
            row = rows.pop(rng.randrange(len(rows)))
            now = state_of(row) or {}
            if choice < 0.6:
                rows.append(does(row.id, now | {"name": word}, partial(library.rename, row, word)))
            elif choice < 0.8:
                will = now | {"tags": sorted({*now["tags"], word})}
                rows.append(does(row.id, will, partial(library.tag, row, word)))
            elif choice < 0.88:
                does(row.id, now | {"binned": True}, partial(library.bin, row))
            else:
                rows.append(row)
                if choice < 0.93:
                    library.empty_bin()
                elif choice < 0.97:
                    library.reindex()
                else:
                    archive.unlink(missing_ok=True)
                    library.backup(archive)


def begin(folder: Path, url: str | None, seed: int) -> tuple[int, int]:
    """Start such a process; its id, and where it says what it does."""
    read, write = os.pipe()
    process = os.fork()
    if process:
        os.close(write)
        return process, read
    try:
        work(folder, url, seed, lambda told: _say(write, told))
    except BaseException as error:  # noqa: BLE001  Told to the parent, which ends with it.
        _say(write, {"error": f"{type(error).__name__}: {error}"})
    finally:
        os._exit(1)


def _say(pipe: int, told: Mapping[str, Any]) -> None:
    """A line of JSON."""
    os.write(pipe, (json.dumps(told) + "\n").encode())


def killed(folder: Path, url: str | None, rng: random.Random, expected: Expected) -> None:
    """Two processes, killed; what they said is heard."""
    processes = [begin(folder, url, rng.randrange(2**31)) for _ in range(2)]
    early = rng.random() < EARLY
    if not early:
        select.select([read for _, read in processes], [], [], 60.0)
    time.sleep(rng.uniform(0.0, 0.05 if early else LONGEST))
    for process, _ in processes:
        os.kill(process, signal.SIGKILL)
    for process, read in processes:
        os.waitpid(process, 0)
        with os.fdopen(read, "rb") as pipe:
            expected.hear(pipe.read())


def kills(rounds: int, seed: int, url: str | None) -> dict[str, Any]:
    """All rounds, and what was lost."""
    rng = random.Random(seed)
    expected = Expected()
    lost, findings, restored, acknowledged = 0, 0, 0, 0
    folder = Path(tempfile.mkdtemp(prefix="burnish-kills-"))
    for number in range(rounds):
        if number % FRESH == 0:
            acknowledged += expected.acknowledged
            folder, expected = anew(folder, url), Expected(trouble=expected.trouble)
        killed(folder, url, rng, expected)
        if number % FRESH == FRESH - 1:
            damage(folder, url, rng)
            restored += 1
        with Library.open(folder / "library", url) as library:
            findings += len(library.check())
            found = {row.id: state_of(row) for row in library.everything()}
        lost += len(expected.settle(found))
    shutil.rmtree(folder)
    if expected.trouble:
        raise SystemExit(f"a process ended by itself: {expected.trouble[0]}")
    return {
        "processes_killed": 2 * rounds,
        "acknowledged_changes": acknowledged + expected.acknowledged,
        "lost_rows": lost,
        "findings_of_check": findings,
        "databases_destroyed_and_rebuilt": restored,
    }


def anew(folder: Path, url: str | None) -> Path:
    """An empty place."""
    shutil.rmtree(folder)
    folder.mkdir()
    if url is not None:
        _dropped(folder, url)
    return folder


def damage(folder: Path, url: str | None, rng: random.Random) -> None:
    """Destroy the database, and have it built anew."""
    with Library.at(folder / "library", url) as library:
        if url is None:
            library.database.file.write_bytes(rng.randbytes(50_000))
            try:
                Library.open(folder / "library").close()
            except BurnishError:
                pass
            else:
                raise SystemExit("a destroyed database was opened")
        else:
            _dropped(folder, url)
        library.reindex()


def _dropped(folder: Path, url: str) -> None:
    """An empty PostgreSQL database."""
    with Library.at(folder / "library", url) as library, library.database.connection() as connection:
        connection.execute(text("DROP SCHEMA public CASCADE"))
        connection.execute(text("CREATE SCHEMA public"))


# Speed.


def fill(root: Path, count: int, seed: int) -> None:
    """Cards and files of so many runs; the database is built from them."""
    rng = random.Random(seed)
    start = datetime.now(timezone.utc) - timedelta(minutes=count)
    for number in range(count):
        pieces = {
            "recording": (rng.randbytes(2000), ".mcap"),
            "metrics": (json.dumps({"force_rms_N": rng.random()}).encode(), ".json"),
            "report": (f"<h1>{number}</h1>{rng.random()}".encode(), ".html"),
        }
        files = tuple(_kept(root, role, content, ending) for role, (content, ending) in pieces.items())
        mould = f"part {number % 200}"
        row = RunRow(
            id=identity(RunRow, str(number)),
            name=f"{rng.choice(WORDS)} {number}",
            created=start + timedelta(minutes=number),
            files=files,
            tags=tuple(rng.sample(WORDS, 2)),
            notes=" ".join(rng.choices(WORDS, k=40)),
            verb="polish",
            mould=mould,
            mould_sha256=hashlib.sha256(mould.encode()).hexdigest(),
            arm="honest",
            sensor="wrist",
            ended=rng.choice(("done", "done", "done", "stopped", "interrupted")),
            outcome="done",
            duration=rng.uniform(60.0, 3600.0),
            folder=f"runs/{number}",
            metrics={f"figure_{k}": rng.random() for k in range(25)},
        )
        card_path(root, row.id).write_bytes(card_bytes(row))


def _kept(root: Path, role: str, content: bytes, ending: str) -> Stored:
    stored = Stored(role=role, sha256=hashlib.sha256(content).hexdigest(), size=len(content), ending=ending)
    (root / stored.path).parent.mkdir(parents=True, exist_ok=True)
    (root / stored.path).write_bytes(content)
    return stored


def speed(count: int, seed: int, url: str | None) -> dict[str, Any]:
    """Times of what a person waits for [ms]."""
    folder = Path(tempfile.mkdtemp(prefix="burnish-speed-"))
    root = anew(folder, url) / "library"
    rng = random.Random(seed)
    with Library.open(root, url) as library:
        fill(root, count, seed)
        start = time.perf_counter()
        rebuilt = library.reindex()
        reindex = time.perf_counter() - start
        assert (rebuilt.rows, rebuilt.findings) == (count, ()), rebuilt
        start = time.perf_counter()
        assert library.check() == []
        check = time.perf_counter() - start

        def opened() -> None:
            row = library.get(RunRow, identity(RunRow, str(rng.randrange(count))))
            assert library.file(row, "report").read_bytes()

        calls: dict[str, Callable[[], object]] = {
            "open the library": lambda: Library.open(root, url).close(),
            "list the newest 50": library.runs,
            "list the oldest 50": lambda: library.runs(offset=max(count - 50, 0)),
            "search one word": lambda: library.runs(rng.choice(WORDS)),
            "search three words": lambda: library.runs(" ".join(rng.sample(WORDS, 3))),
            "search what is nowhere": lambda: library.runs("nowhere"),
            "runs of a mould": lambda: library.runs(mould=f"part {rng.randrange(200)}"),
            "runs with a tag that were stopped": lambda: library.runs(tag=rng.choice(WORDS), ended="stopped"),
            "count a search": lambda: library.count(RunRow, rng.choice(WORDS)),
            "all tags": library.tags,
            "open a run and its report": opened,
            "rename a run": lambda: library.rename(library.runs(limit=1)[0], rng.choice(WORDS)),
        }
        times = {name: _timed(call) for name, call in calls.items()}
    shutil.rmtree(folder)
    return {
        "rows": count,
        "load_average": round(os.getloadavg()[0], 1),
        "reindex_s": round(reindex, 1),
        "check_s": round(check, 1),
        "ms": times,
    }


def _timed(call: Callable[[], object]) -> dict[str, float]:
    taken = []
    for _ in range(CALLS):
        start = time.perf_counter()
        call()
        taken.append(1e3 * (time.perf_counter() - start))
    return {"median": round(statistics.median(taken), 1), "worst": round(max(taken), 1)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=0, help="size of the library that is timed (default: none)")
    parser.add_argument("--kills", type=int, default=0, metavar="ROUNDS", help="of two processes each (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--database", metavar="URL", help="an empty one; what is in it is lost (default: SQLite)")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    kind = "sqlite" if options.database is None else "postgresql"
    found: dict[str, Any] = {}
    if options.rows:
        found["speed"] = speed(options.rows, options.seed, options.database)
    if options.kills:
        found["kills"] = kills(options.kills, options.seed, options.database)
    # The results of the two databases stand side by side in one file.
    known = json.loads(options.out.read_text()) if options.out.exists() else {}
    write_json(options.out, {**known, **machine(), kind: known.get(kind, {}) | found})
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
