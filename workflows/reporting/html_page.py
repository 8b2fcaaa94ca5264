"""HTML pages that need no other file."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from pathlib import Path

from cfmpm.output.files import written_aside


def write_text(text: str, path: str | Path) -> None:
    """Write a text file aside and rename it."""
    with written_aside(Path(path)) as aside:
        aside.write_text(text, encoding="utf-8")


def html_page(title: str, body: str) -> str:
    """Return a whole HTML page."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style></head>\n"
        f"<body>\n<h1>{html.escape(title)}</h1>\n{body}</body></html>\n"
    )


def html_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], classes: Sequence[str] | None = None
) -> str:
    """Return a table of plain text; a class of a row is one that the page's style knows."""
    rows = list(rows)
    marks = [f' class="{one}"' for one in classes] if classes else [""] * len(rows)
    lines = "".join(
        f"<tr{mark}>{_row(row, 'td')}</tr>\n" for row, mark in zip(rows, marks, strict=True)
    )
    return f"<table>\n<tr>{_row(head, 'th')}</tr>\n{lines}</table>\n"


def html_image(picture: str | Path, text: str) -> str:
    """Return an image with its file inside."""
    inside = base64.b64encode(Path(picture).read_bytes()).decode()
    return f'<img alt="{html.escape(text)}" src="data:image/png;base64,{inside}">'


def _row(cells: Iterable[str], tag: str) -> str:
    return "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)


# A bar beside each verdict and its word in the row: not by colour alone.
_STYLE = """
body { font: 14px/1.4 sans-serif; color: #222; margin: 1.5em; }
table { border-collapse: collapse; margin: 0.5em 0 1em; }
td, th { border: 1px solid #bbb; padding: 4px 8px; text-align: left; vertical-align: top; }
tr.yes td:first-child { border-left: 6px solid #009e73; }
tr.in-part td:first-child { border-left: 6px solid #e69f00; }
tr.no td:first-child { border-left: 6px solid #d55e00; }
tr.misprint td:first-child { border-left: 6px solid #56b4e9; }
figure { margin: 1em 0 2em; display: grid; gap: 1em; align-items: start; }
img { max-width: 100%; }
figure img { width: 100%; }
@media (min-width: 1000px) { figure { grid-template-columns: 2fr 3fr; } }
figcaption table { font-size: 12px; }
"""
