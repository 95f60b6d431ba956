"""The process behind `Screen`: on a terminal a picture that is drawn anew, in a pipe a line now and then."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from burnish.commands.screen import View

WIDTH = 36
"""Of a bar, in characters."""
NEAR, TOO_NEAR = 15.0, 5.0
"""Distance from a joint limit at which a bar is yellow, and red [deg]: where the joint is pushed back, and stopped."""
EVERY = 1.0
"""Time between two lines in a pipe, unless something happens [s]."""
COLOURS = {"torque": "green", "hold": "bold yellow", "fault": "bold red"}
NEXT = {"hold": "press a to acknowledge", "fault": "read this, then press r to reset"}


def main() -> None:
    """Draw what comes down the pipe until it ends."""
    try:
        if sys.stdout.isatty():
            with Live(console=Console(), screen=True, auto_refresh=False) as live:
                for views in arriving():
                    live.update(picture(views[-1]), refresh=True)
        else:
            shown = None
            for views in arriving():
                for view in views:
                    if shown is None or worth_a_line(shown, view):
                        print(line(view), flush=True)
                        shown = view
    except OSError:
        # The terminal or the pipe was closed. Whoever operates the arm finds out in another way.
        os._exit(1)


def arriving() -> Iterator[list[View]]:
    """All that has come since the last look, oldest first; a slow terminal is no reason to fall behind."""
    rest = b""
    while data := os.read(0, 1 << 16):
        *lines, rest = (rest + data).split(b"\n")
        if lines:
            yield [View(**json.loads(each)) for each in lines]


def picture(view: View) -> Table:
    """The whole screen."""
    table = Table.grid(padding=(0, 2))
    table.add_row(Text("burnish", style="bold"), Text(f"{view.title}, {view.t:.1f} s"))
    table.add_row("mode", Text(f"{view.mode}", style="bold cyan") + Text(f"   {view.moves}   {view.deadman}"))
    age = "gone" if view.age is None else f"{1e3 * view.age:.0f} ms"
    table.add_row("device", Text(f"{view.device}, {age}", style="bold red" if view.age is None else ""))
    table.add_row("slowed by", Text(view.slowed or "nothing", style="yellow" if view.slowed else "dim"))
    table.add_row(
        "position", "  ".join(f"{axis} {value:+.3f}" for axis, value in zip("xyz", view.p, strict=True)) + " m"
    )
    table.add_row("turned", "  ".join(f"{a} {v:+.1f}" for a, v in zip("xyz", view.angles, strict=True)) + " °")
    table.add_row("speed", f"{1e3 * view.speed:.0f} mm/s")
    table.add_row("force", force(view))
    for number, (q, low, high) in enumerate(zip(view.q, view.lower, view.upper, strict=True), 1):
        table.add_row(f"joint {number}", bar(q, low, high))
    if view.fingers is not None:
        table.add_row("fingers", f"{view.fingers:.0f}° of 80° closed")
    table.add_row("rate", f"{view.rate:.0f} Hz, {view.late} late of {view.cycles}")
    state = Text(view.supervisor.upper() if view.cause else view.supervisor, style=COLOURS.get(view.supervisor, ""))
    if view.cause:
        state += Text(f": {view.cause}; {NEXT.get(view.supervisor, '')}")
    table.add_row("supervisor", state)
    table.add_row("buttons", "   ".join(f"{button} {what}" for button, what in view.buttons.items()))
    table.add_row("keys", "   ".join(f"{key} {what}" for key, what in view.keys.items()))
    table.add_row("", Text(view.note, style="yellow"))
    return table


def bar(q: float, low: float | None, high: float | None) -> Text:
    """Where a joint is between its limits."""
    if low is None or high is None:
        return Text(f"{'turns for ever':<{WIDTH + 2}} {q:+7.1f}°", style="dim")
    place = round((WIDTH - 1) * min(max((q - low) / (high - low), 0.0), 1.0))
    left = min(q - low, high - q)
    style = "red" if left < TOO_NEAR else "yellow" if left < NEAR else "green"
    drawn = (
        Text("│" + "·" * place, style="dim")
        + Text("█", style=style)
        + Text("·" * (WIDTH - 1 - place) + "│", style="dim")
    )
    return drawn + Text(f" {q:+7.1f}°, {left:.0f}° left", style=style)


def force(view: View) -> str:
    """The contact force in words."""
    if view.force is None:
        return "not measured"
    x, y, z = view.force
    return f"x {x:+.1f}  y {y:+.1f}  z {z:+.1f} N, {(x * x + y * y + z * z) ** 0.5:.1f} N in all"


def worth_a_line(shown: View, view: View) -> bool:
    """Whether something has happened, or a second has gone by."""
    seen, now = ((v.mode, v.supervisor, v.cause, v.age is None, v.note) for v in (shown, view))
    return seen != now or view.t - shown.t >= EVERY


def line(view: View) -> str:
    """The same in a line without colours."""
    x, y, z = view.p
    parts = [
        f"{view.t:7.1f} s",
        view.mode,
        f"tool {x:+.3f} {y:+.3f} {z:+.3f} m",
        force(view) if view.force is not None else "",
        f"slowed by {view.slowed}" if view.slowed else "",
        f"{view.device} is gone" if view.age is None else "",
        f"{view.supervisor}: {view.cause}" if view.cause else view.supervisor,
        view.note,
    ]
    return ", ".join(part for part in parts if part)


if __name__ == "__main__":
    main()
