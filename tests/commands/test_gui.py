import argparse
import re
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from burnish.commands.gui import run
from burnish.commands.gui_options import add_gui
from burnish.errors import InputError

LINE = (
    "import sys; from burnish.commands.gui_options import add_gui; from burnish.commands.gui import run; "
    "from burnish.cli import Parser; parser = Parser(); add_gui(parser); sys.exit(run(parser.parse_args()))"
)


def options(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_gui(parser)
    return parser.parse_args(words)


def test_a_port_that_is_none_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="out of range"):
        run(options("--port", "70000", "--library", str(tmp_path / "library"), "--no-browser"))
    assert not (tmp_path / "library").exists()


def test_one_line_is_printed_it_is_the_address_and_ctrl_c_ends_the_workshop(tmp_path: Path) -> None:
    command = [sys.executable, "-c", LINE, "--port", "0", "--library", str(tmp_path), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = re.fullmatch(r"workshop: (http://127\.0\.0\.1:\d+/\?token=\S+)\n", process.stdout.readline())[1]
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(address.split("?")[0])
        assert refused.value.code == 401
        process.send_signal(2)
        rest, _ = process.communicate(timeout=60)
        assert process.returncode == 0
        assert rest == ""
