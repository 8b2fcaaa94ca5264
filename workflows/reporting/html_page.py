"""HTML pages that need no other file."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from PIL import Image

from cfmpm.output.files import written_aside

# Of an image in a page [pixels], and its colours: enough for lines and text on any screen.
WIDEST, COLOURS = 1400, 128
# Numbers such as 1.2e-5, powers such as h^1.5, and symbols with an index, as K_I.
_POWER = re.compile(r"\b(?:(\d+\.\d+|[02-9]|\d\d+|1)e)([+-]?)0*(\d+)\b")
_EXPONENT = re.compile(r"\^(\d+(?:\.\d+)?)")
_INDEX = re.compile(r"\b([A-Za-z])_(\w{1,3})\b")


def write_text(text: str, path: str | Path) -> None:
    """Write a text file aside and rename it."""
    with written_aside(Path(path)) as aside:
        aside.write_text(text, encoding="utf-8")


def html_page(title: str, body: str, style: str = "") -> str:
    """Return a whole HTML page; a style follows that of all pages."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}{style}</style></head>\n"
        f"<body>\n<h1>{html.escape(title)}</h1>\n{body}</body></html>\n"
    )


def html_text(text: str) -> str:
    """Return plain text as HTML, with powers of ten, indices and relations as in print."""

    def power(found: re.Match[str]) -> str:
        factor, sign, exponent = found.groups()
        minus = "−" if sign == "-" else ""
        times = "" if factor == "1" else f"{factor} × "
        return f"{times}10<sup>{minus}{exponent}</sup>"

    text = html.escape(text.replace(">=", "≥").replace("<=", "≤"))
    text = _EXPONENT.sub(r"<sup>\1</sup>", text)
    return _INDEX.sub(r"\1<sub>\2</sub>", _POWER.sub(power, text))


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
    """Return an image with its file inside: a smaller copy, or the whole of an animated one."""
    inside = base64.b64encode(_copy(Path(picture))).decode()
    return f'<img alt="{html.escape(text)}" src="data:image/png;base64,{inside}">'


def _copy(picture: Path) -> bytes:
    with Image.open(picture) as image:
        if getattr(image, "is_animated", False):
            return picture.read_bytes()
        small = image.convert("RGB")
    if small.width > WIDEST:
        size = (WIDEST, round(small.height * WIDEST / small.width))
        small = small.resize(size, Image.Resampling.LANCZOS)
    written = io.BytesIO()
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(written, "PNG", optimize=True)
    return written.getvalue()


def _row(cells: Iterable[str], tag: str) -> str:
    return "".join(f"<{tag}>{html_text(cell)}</{tag}>" for cell in cells)


# A bar beside each verdict and its word in the row: not by colour alone.
_STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; color: #222; margin: 1.5em; }
table { border-collapse: collapse; margin: 0.5em 0 1em; }
td, th { border: 1px solid #ccc; padding: 4px 8px; text-align: left; vertical-align: top; }
th { background: #f3f3f3; }
tr.yes td:first-child { border-left: 6px solid #009e73; }
tr.in-part td:first-child { border-left: 6px solid #e69f00; }
tr.no td:first-child { border-left: 6px solid #d55e00; }
tr.misprint td:first-child { border-left: 6px solid #56b4e9; }
tr.not-tested td:first-child { border-left: 6px solid #999; }
sub, sup { line-height: 0; font-size: 75%; }
img { max-width: 100%; }
"""
