"""The process of the stand-in's arm: ``python arm.py MEMORY``.

Takes one JSON line at a time and answers each with a line: ``{"reset": {...}}`` with the words of `Options`,
``{"advance": seconds}`` for an arm on simulated time, ``{"off": true}``. An arm on real time lives by the
clock in between.
"""

from __future__ import annotations

import json
import select
import sys
from pathlib import Path
from time import monotonic

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from hardware.firmware import Firmware, options_of
from hardware.memory import attach
from hardware.standin import urgent

SLIP = 0.1
"""Real time that the arm lets go when its process did not get the processor for that long [s]."""
NAP = 2e-3


def main() -> None:
    urgent()
    memory = attach(sys.argv[1])
    firmware, began = None, None
    while True:
        if began is None or select.select([sys.stdin], [], [], NAP)[0]:
            line = sys.stdin.readline()
            if not line:
                return
            words = json.loads(line)
            if "reset" in words:
                options = options_of(words["reset"])
                firmware = Firmware(memory, options)
                began = monotonic() - firmware.time if options.realtime else None
            elif "off" in words:
                firmware, began = None, None
                memory.lived = 0.0
            elif firmware is not None:
                firmware.advance(firmware.time + words["advance"])
            print("done", flush=True)
        if began is not None and firmware is not None:
            now = monotonic() - began
            if now - firmware.time > SLIP:
                began += now - firmware.time - NAP
            now = monotonic()
            firmware.advance(now - began)
            memory.lived = now


if __name__ == "__main__":
    main()
