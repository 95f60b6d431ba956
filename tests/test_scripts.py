"""The scripts that make committed files still make them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent


def test_picture_of_the_orientation_errors_is_drawn(tmp_path: Path) -> None:
    # Another release of the plotting library draws other bytes, so those are not compared.
    drawn = tmp_path / "errors.svg"
    subprocess.run([sys.executable, str(ROOT / "scripts" / "plot_orientation_errors.py"), str(drawn)], check=True)
    for path in (drawn, ROOT / "docs" / "images" / "orientation-errors.svg"):
        assert ElementTree.parse(path).getroot().tag == "{http://www.w3.org/2000/svg}svg"
