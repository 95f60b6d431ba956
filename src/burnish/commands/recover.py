"""``burnish recover``: all whole messages of a recording that was cut off or damaged, in a new file."""

from __future__ import annotations

import argparse
from pathlib import Path

from burnish.commands.options import relative
from burnish.record.recover import recover


def run(options: argparse.Namespace) -> int:
    """Mend, and say what was saved and what was lost."""
    path = Path(options.file)
    out = Path(options.out) if options.out else path.with_name(f"{path.stem}.recovered.mcap")
    saved = recover(path, out)
    span = ""
    if saved.first is not None and saved.last is not None:
        span = f", t = {1e-9 * saved.first:.3f} s to {1e-9 * saved.last:.3f} s"
    print(f"Saved: {saved.messages} messages{span}.")
    if saved.damages:
        print(f"Lost: {saved.unread} bytes that give no whole message.")
        for damage in saved.damages[:5]:
            print(f"  byte {damage.start}: {damage.reason}")
        if len(saved.damages) > 5:
            print(f"  and {len(saved.damages) - 5} places more")
    else:
        print("Lost: nothing, the file was whole.")
    print(f"recording: {relative(out)}")
    return 0
