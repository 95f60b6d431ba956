"""Pieces of one self-contained HTML page: everything from outside is escaped, nothing is fetched."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from burnish.analysis.glossary import figure

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
"""The browser itself refuses any request that the page might make."""


def page(title: str, body: Iterable[str]) -> str:
    """The whole document; ``title`` is plain text, ``body`` is HTML."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light"><title>{escape(title)}</title>'
        f"<style>{STYLE}</style></head>\n<body><main>\n" + "\n".join(body) + "\n</main></body></html>\n"
    )


def section(heading: str, *content: str) -> str:
    """A part of the page under a heading (plain text); nothing when there is no content."""
    inner = "\n".join(part for part in content if part)
    return f"<section><h2>{escape(heading)}</h2>\n{inner}\n</section>" if inner else ""


def picture(source: str, description: str, caption: str = "") -> str:
    """An image from a ``data:`` address."""
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img src="{escape(source)}" alt="{escape(description)}">{below}</figure>'


def drawing(svg: str, caption: str = "") -> str:
    """An inline ``<svg>`` of our own."""
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f"<figure>{svg}{below}</figure>"


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], numeric: int = -1) -> str:
    """A table of plain texts; the column ``numeric`` is set to the right. Empty without rows."""
    lines = list(rows)
    if not lines:
        return ""

    def cells(tag: str, texts: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{' class=number' if i == numeric else ''}>{escape(text)}</{tag}>" for i, text in enumerate(texts)
        )

    head = f"<thead><tr>{cells('th', headings)}</tr></thead>"
    rest = "".join(f"<tr>{cells('td', line)}</tr>" for line in lines)
    return f'<div class="wide"><table>{head}<tbody>{rest}</tbody></table></div>'


def pairs(items: Mapping[str, object]) -> str:
    """Names and values, side by side in columns."""
    if not items:
        return ""
    rows = "".join(f"<div><dt>{escape(str(k))}</dt><dd>{escape(figure(v))}</dd></div>" for k, v in items.items())
    return f"<dl>{rows}</dl>"


def card(label: str, value: str, unit: str) -> str:
    """One key figure."""
    return (
        f'<div class="card"><span class="label">{escape(label)}</span>'
        f'<span class="value">{escape(value)}<small>{escape(unit)}</small></span></div>'
    )


STYLE = """
:root{--ink:#1d2329;--soft:#5b6470;--line:#dde1e6;--paper:#fff;--ground:#f4f5f7}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);
font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
main{max-width:1120px;margin:0 auto;padding:2rem clamp(.8rem,3vw,2rem) 4rem}
header{display:flex;flex-wrap:wrap;align-items:baseline;gap:.4rem 1rem;margin-bottom:1rem}
h1{font-size:clamp(1.5rem,3.2vw,2.1rem);line-height:1.2;margin:0;font-weight:650;letter-spacing:-.01em}
h2{font-size:1.15rem;margin:0 0 .8rem;font-weight:650}
.verdict{padding:.15rem .8rem;border-radius:999px;font-weight:600;font-size:.95rem;overflow-wrap:anywhere}
.done{background:#dcefe3;color:#0f5a34}
.stopped{background:#fbe3dc;color:#8f2d0c}
.interrupted{background:#fbf0d2;color:#6f4e00}
.note{flex-basis:100%;margin:0;color:var(--soft);font-size:.95rem}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:.8rem;margin:0 0 1rem}
.card{background:var(--paper);border:1px solid var(--line);border-radius:8px;padding:.8rem 1rem}
.card .label{display:block;color:var(--soft);font-size:.85rem}
.card .value{font-size:1.75rem;font-weight:620;font-variant-numeric:tabular-nums;letter-spacing:-.01em}
.card small{font-size:.95rem;font-weight:400;color:var(--soft);margin-left:.25em}
section{background:var(--paper);border:1px solid var(--line);border-radius:8px;
padding:1.2rem clamp(.8rem,2.5vw,1.5rem);
margin:1rem 0}
figure{margin:0}figure+figure{margin-top:1rem}
figure img,figure svg{display:block;width:100%;height:auto}
figcaption{color:var(--soft);font-size:.88rem;margin-top:.4rem}
.hero{background:var(--paper);border:1px solid var(--line);border-radius:8px;overflow:hidden}
.hero figcaption{padding:0 1rem .6rem}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(400px,100%),1fr));gap:1rem;margin-bottom:1rem}
.columns figure{margin:0}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.93rem}
th{text-align:left;font-weight:600;color:var(--soft);font-size:.85rem}
th,td{padding:.38rem .8rem .38rem 0;border-bottom:1px solid var(--line);vertical-align:top}
.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(240px,100%),1fr));gap:0 2rem;margin:0;
font-size:.93rem}
dl div{display:flex;justify-content:space-between;gap:1rem;padding:.34rem 0;border-bottom:1px solid var(--line)}
dt{color:var(--soft)}dd{margin:0;text-align:right;overflow-wrap:anywhere;font-variant-numeric:tabular-nums}
.hint,.without{color:var(--soft);font-size:.88rem;margin:.5rem 0 0}
footer{color:var(--soft);font-size:.85rem;margin-top:1.5rem}
@media print{@page{margin:14mm}
body{background:#fff;font-size:11pt}main{max-width:none;padding:0}
section,.card,.hero{border-color:#bbb;break-inside:avoid}.screen{display:none}h2{break-after:avoid}
.cards{grid-template-columns:repeat(5,1fr)}.columns{grid-template-columns:1fr 1fr}
.card .value{font-size:1.3rem}.verdict{border:1px solid currentColor}}
"""
