"""The table of a section: what the paper says, what is known otherwise, what was computed."""

from __future__ import annotations

import csv
import html
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from cfmpm.results import written_aside

# Of the table to be read; the CSV file has all fields.
SHOWN = ("claim", "paper", "reference", "cfmpm", "error", "held", "test")


@dataclass(frozen=True)
class Claim:
    """One line of the table.

    Attributes
    ----------
    claim : str
    paper, reference, cfmpm : str
        What the paper says, what is known otherwise, what the datasets say.
    held : str
        yes, no, or in part; misprint where the paper's words do not fit its own numbers. Further
        words may follow a comma.
    test : str
        By what it was decided.
    error : str
        How far the datasets are from the reference.
    figures : str
        In which figures it is seen: their numbers, separated by blanks.
    """

    claim: str
    paper: str
    reference: str
    cfmpm: str
    held: str
    test: str
    error: str = ""
    figures: str = ""

    @property
    def verdict(self) -> str:
        """The first word of `held`."""
        return self.held.split(",")[0]


def write_table(
    claims: Sequence[Claim], title: str, table: str | Path, markdown: str | Path, page: str | Path
) -> None:
    """Write claims as CSV, Markdown and HTML.

    Parameters
    ----------
    claims : sequence of Claim
    title : str
        Of the HTML page.
    table, markdown, page : Path
        Each is written aside and renamed.
    """
    with (
        written_aside(Path(table)) as aside,
        aside.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.DictWriter(file, [field.name for field in fields(Claim)])
        writer.writeheader()
        writer.writerows(asdict(claim) for claim in claims)
    lines = [SHOWN, ["---"] * len(SHOWN), *(_cells(claim) for claim in claims)]
    write_text("".join(f"| {' | '.join(line)} |\n" for line in lines), markdown)
    write_text(html_page(title, html_table(claims)), page)


def read_table(path: str | Path) -> list[Claim]:
    """Read the claims of a CSV file back."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return [Claim(**row) for row in csv.DictReader(file)]


def write_text(text: str, path: str | Path) -> None:
    """Write a text file aside and rename it."""
    with written_aside(Path(path)) as aside:
        aside.write_text(text, encoding="utf-8")


def html_table(claims: Iterable[Claim], columns: Sequence[str] = SHOWN) -> str:
    """Return claims as an HTML table, one row each below a head."""
    rows = "".join(
        f'<tr class="{claim.verdict.replace(" ", "-")}">{_row(_cells(claim, columns), "td")}</tr>\n'
        for claim in claims
    )
    return f"<table>\n<tr>{_row(columns, 'th')}</tr>\n{rows}</table>\n"


def html_page(title: str, body: str) -> str:
    """Return a whole HTML page that needs no other file."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style></head>\n"
        f"<body>\n<h1>{html.escape(title)}</h1>\n{body}</body></html>\n"
    )


def _cells(claim: Claim, columns: Sequence[str] = SHOWN) -> list[str]:
    return [getattr(claim, name) for name in columns]


def _row(cells: Iterable[str], tag: str) -> str:
    return "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)


# A bar beside each line and its word in the column "held": not by colour alone.
_STYLE = """
body { font: 14px/1.4 sans-serif; color: #222; margin: 1.5em; }
table { border-collapse: collapse; margin: 0.5em 0 1em; }
td, th { border: 1px solid #bbb; padding: 4px 8px; text-align: left; vertical-align: top; }
tr.yes td:first-child { border-left: 6px solid #009e73; }
tr.in-part td:first-child { border-left: 6px solid #e69f00; }
tr.no td:first-child { border-left: 6px solid #d55e00; }
tr.misprint td:first-child { border-left: 6px solid #56b4e9; }
figure { margin: 1em 0 2em; display: grid; gap: 1em; align-items: start; }
figure img { width: 100%; }
@media (min-width: 1000px) { figure { grid-template-columns: 2fr 3fr; } }
figcaption table { font-size: 12px; }
"""
