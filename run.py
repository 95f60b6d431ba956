"""Make .venv ready once, then run burnish or its tests in it: ``python3 run.py polish``.

Standard library only. No f-strings and no annotations: a Python that is too old has to be able to read this
file, so that it can say so.
"""

from __future__ import print_function

import hashlib
import os
import shutil
import subprocess
import sys
import time

USAGE = """\
usage: python3 run.py polish [options]       polish the bundled dome, report under runs/
       python3 run.py test [pytest options]  the quick everyday tests
       python3 run.py setup                  make .venv ready and stop
       python3 run.py VERB [options]         any other verb of the burnish command (plan --mould wave ...)

The first call sets up .venv from requirements.lock.txt; `python3 run.py VERB --help` explains a verb."""

ROOT = os.path.dirname(os.path.realpath(__file__))
VENV = os.path.join(ROOT, ".venv")
PYTHON = os.path.join(VENV, "bin", "python")
LOCK = os.path.join(ROOT, "requirements.lock.txt")
STAMP = os.path.join(VENV, "set-up")
UNFINISHED = os.path.join(VENV, "set-up-unfinished")
VERSION = sys.version.split()[0]


def main(words):
    """Run what the first word names; this process becomes that command, so its exit status is ours."""
    if not words or words[0] in ("-h", "--help"):
        print(USAGE)
        return
    if not (3, 10) <= sys.version_info[:2] <= (3, 13):
        stop("this is Python {}; burnish needs 3.10 to 3.13 (try: python3.12 run.py ...)".format(VERSION), 2)
    if os.name == "nt":
        stop("burnish runs on Linux; on Windows use it inside WSL", 2)
    try:
        set_up()
    except KeyboardInterrupt:
        stop("interrupted; the next call sets .venv up afresh", 130)
    except OSError as error:
        stop("cannot set up .venv: {}".format(error), 1)
    if words[0] == "setup":
        return
    if words[0] == "test":
        os.chdir(ROOT)
        # On all cores; tests/conftest.py says which tests stay together. In their order, as without it.
        shared = ["--numprocesses", "auto", "--dist", "loadgroup", "--no-loadscope-reorder"]
        os.execv(PYTHON, [PYTHON, "-m", "pytest"] + shared + words[1:])
    # Through the interpreter: the script's own "#!" line would break when the clone is long or spaced of name.
    os.execv(PYTHON, [PYTHON, os.path.join(VENV, "bin", "burnish")] + words)


def set_up():
    """Make .venv hold exactly what this clone asks for; return at once where it does already."""
    # Here, because Windows and Pythons that main() has refused by now lack them.
    import fcntl
    import importlib.util

    if is_ready():
        return
    uv = shutil.which("uv")
    if not uv and importlib.util.find_spec("ensurepip") is None:
        stop("this Python cannot make a virtual environment; what it lacks: sudo apt install python3-venv", 2)
    started = time.time()
    say("Setting up .venv (once, a minute or two) ...")
    with open(LOCK, "r+b") as turn:
        # Of two first calls the second waits here. The child processes inherit the lock: where this process is
        # killed, the installer that it leaves behind still keeps the next call out.
        os.set_inheritable(turn.fileno(), True)
        fcntl.flock(turn, fcntl.LOCK_EX)
        if is_ready():
            return
        if not can_be_completed(uv):
            make_environment(uv)
        mark_unfinished()
        pip = [uv, "pip", "install", "--python", PYTHON] if uv else [PYTHON, "-m", "pip", "install"]
        say("  installing the packages of requirements.lock.txt ...")
        step(pip + ["--require-hashes", "--only-binary", ":all:", "-r", LOCK])
        say("  installing burnish itself ...")
        step(pip + ["--no-index", "--no-deps", "--no-build-isolation", "-e", "."])
        with open(STAMP, "w") as stamp:
            stamp.write(wanted_stamp())
        os.remove(UNFINISHED)
        say("  ready after {:.0f} s".format(time.time() - started))


def is_ready():
    """Whether a set-up was finished for this interpreter, this place and the files as they are now."""
    return os.access(PYTHON, os.X_OK) and not os.path.exists(UNFINISHED) and stamp_found() == wanted_stamp()


def wanted_stamp():
    """Line 1: interpreter and place, which only a new .venv can follow; line 2: the files to install from."""
    files = hashlib.sha256()
    for path in (LOCK, os.path.join(ROOT, "pyproject.toml")):
        with open(path, "rb") as file:
            files.update(file.read())
    return "Python {} in {}\n{}\n".format(VERSION, VENV, files.hexdigest())


def stamp_found():
    """What the last finished set-up wrote down; empty where none was finished."""
    if not os.path.isfile(STAMP):
        return ""
    with open(STAMP) as stamp:
        return stamp.read()


def can_be_completed(uv):
    """Whether installing over .venv is enough: it answers, suits this Python, and nothing in it is half done.

    A .venv made by hand carries no stamp; it is kept, too, where it passes the same questions.
    """
    place = stamp_found().splitlines()[:1]
    if os.path.exists(UNFINISHED) or place not in ([], wanted_stamp().splitlines()[:1]):
        return False
    question = "import sys{}; sys.exit(sys.version.split()[0] != {!r} or sys.prefix == sys.base_prefix)"
    question = question.format("" if uv else ", pip", VERSION)
    return os.access(PYTHON, os.X_OK) and subprocess.call([PYTHON, "-c", question], stderr=subprocess.DEVNULL) == 0


def make_environment(uv):
    """An empty .venv in place of whatever stands there."""
    # Called from inside .venv, sys.executable is about to be removed; the interpreter under it stays.
    python = getattr(sys, "_base_executable", sys.executable)
    command = [python, "-m", "venv", VENV]
    if uv:
        command = [uv, "venv", "--no-project", "--allow-existing", "--python", python, VENV]
    if os.path.exists(VENV):
        mark_unfinished()
        # The interpreter goes first: however far the removal gets, the rest is never taken for a sound .venv.
        shutil.rmtree(os.path.join(VENV, "bin"), ignore_errors=True)
        shutil.rmtree(VENV)
    os.mkdir(VENV)
    mark_unfinished()
    step(command)


def mark_unfinished():
    """From here until the marker goes, .venv counts as half made."""
    open(UNFINISHED, "w").close()
    if os.path.exists(STAMP):
        os.remove(STAMP)


def step(command):
    """Run one command of the set-up quietly; where it fails, show the end of what it said and stop."""
    done = subprocess.run(
        command, cwd=ROOT, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    if done.returncode != 0:
        for line in done.stdout.decode("utf-8", "replace").splitlines()[-15:]:
            say("  | " + line)
        stop("setting up .venv failed for the reason above; call again when it is mended", 1)


def say(line):
    """Progress goes to standard error, so that the output of a verb can be piped."""
    print(line, file=sys.stderr)
    sys.stderr.flush()


def stop(sentence, status):
    """End with one plain line."""
    say("run.py: " + sentence)
    sys.exit(status)


if __name__ == "__main__":
    main(sys.argv[1:])
