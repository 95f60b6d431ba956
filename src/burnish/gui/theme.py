"""How the page looks: colours that follow light and dark, and the few pieces of HTML that it is made of.

Everything that comes from a file or from a person is escaped here, and nowhere else is HTML put together.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import viser

BRAND = (30, 115, 190)
"""Of buttons and links."""
WIDTH = 400
"""Of the panel, on a screen of 1280 × 720 and on a tablet [px]."""
COLOURS = {
    "gray": "#868e96",
    "green": "#2b8a3e",
    "blue": "#1c6fb8",
    "orange": "#c25e00",
    "red": "#c92a2a",
}
"""White text can be read on each (WCAG AA)."""
_TEXT = "font-size:0.82em;line-height:1.4;padding:0 0.9em 0.75em;color:var(--mantine-color-text)"
_DIM = "color:var(--mantine-color-dimmed)"


def configure(gui: viser.GuiApi, dark: bool) -> None:
    """Light or dark; nothing of the page's maker, and no link to the outside."""
    gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BRAND)


def text(words: str, *, dim: bool = False) -> str:
    """A sentence."""
    return f'<div style="{_TEXT};{_DIM if dim else ""}">{escape(words)}</div>'


def notice(words: str, colour: str, title: str = "") -> str:
    """A sentence that has to be read."""
    head = f"<b>{escape(title)}</b><br>" if title else ""
    edge = COLOURS[colour]
    return (
        f'<div role="status" style="{_TEXT};margin:0 0.9em 0.5em;padding:0.5em 0.7em;border-left:4px solid {edge};'
        f'background:color-mix(in srgb,{edge} 12%,transparent);border-radius:3px">{head}{escape(words)}</div>'
    )


def chip(words: str, colour: str) -> str:
    """A word on a coloured ground."""
    return (
        f'<span style="background:{COLOURS[colour]};color:#fff;border-radius:9px;padding:0.1em 0.7em;'
        f'font-weight:600;white-space:nowrap">{escape(words)}</span>'
    )


def headline(chips: Sequence[tuple[str, str]], words: str) -> str:
    """The state in one glance."""
    marks = " ".join(chip(*one) for one in chips)
    line = f'<div style="margin-top:0.45em">{escape(words)}</div>'
    return f'<div role="status" aria-live="polite" style="{_TEXT}">{marks}{line}</div>'


def table(rows: Iterable[Sequence[str]], head: Sequence[str] = ()) -> str:
    """Rows of words and figures; figures stand to the right."""
    cell = "padding:0.12em 0.4em;border-bottom:1px solid color-mix(in srgb,currentColor 12%,transparent)"
    lines = []
    if head:
        names = "".join(f'<th scope="col" style="{cell};text-align:{_side(k)};font-weight:600">{escape(word)}</th>'
                        for k, word in enumerate(head))  # fmt: skip
        lines.append(f"<tr>{names}</tr>")
    for row in rows:
        cells = "".join(
            f'<td style="{cell};text-align:{_side(k)};font-variant-numeric:tabular-nums">{escape(word)}</td>'
            for k, word in enumerate(row)
        )
        lines.append(f"<tr>{cells}</tr>")
    return f'<div style="{_TEXT}"><table style="width:100%;border-collapse:collapse">{"".join(lines)}</table></div>'


def legend(colours: Sequence[str], marks: Sequence[tuple[float, str]], title: str) -> str:
    """A bar of colours with marks at shares 0 to 1 of it."""
    bar = f"height:0.7em;border-radius:3px;background:linear-gradient(to right,{','.join(colours)})"
    words = "".join(
        f'<span style="position:absolute;left:{100.0 * share:.0f}%;transform:translateX(-{100.0 * share:.0f}%);'
        f'white-space:nowrap">{escape(word)}</span>'
        for share, word in marks
    )
    return (
        f'<div style="{_TEXT}">{escape(title)}<div style="{bar}"></div>'
        f'<div style="position:relative;height:1.5em;{_DIM}">{words}</div></div>'
    )


def link(words: str, address: str) -> str:
    """A link that opens in a tab of its own."""
    return (
        f'<div style="{_TEXT}"><a href="{escape(address, quote=True)}" target="_blank" rel="noopener">'
        f"{escape(words)}</a></div>"
    )


def link_button(words: str, address: str) -> str:
    """A link that looks like the button that it stands among."""
    red, green, blue = BRAND
    return (
        f'<div style="padding:0 0.55em 0.55em"><a href="{escape(address, quote=True)}" target="_blank" rel="noopener" '
        f'style="display:block;text-align:center;font-size:0.875em;padding:0.35em;border-radius:3px;color:#fff;'
        f'text-decoration:none;background:rgb({red},{green},{blue})">{escape(words)}</a></div>'
    )


def picture(address: str, words: str) -> str:
    """A picture of the library; ``words`` say what it shows, for who does not see it."""
    return (
        f'<div style="{_TEXT}"><img src="{escape(address, quote=True)}" alt="{escape(words, quote=True)}" '
        'style="width:100%;border-radius:4px"></div>'
    )


def _side(column: int) -> str:
    return "left" if column == 0 else "right"
