"""The table of a section: what the paper says, what is known otherwise, what was computed."""

from __future__ import annotations

import csv
import html
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path


@dataclass(frozen=True)
class Claim:
    """One line of the table.

    Attributes
    ----------
    claim : str
    paper, reference, cfmpm : str
        What the paper says, what is known otherwise, what the datasets say.
    held : str
        yes, no, or in part; misprint where the paper's words do not fit its own numbers.
    test : str
        By what it was decided.
    """

    claim: str
    paper: str
    reference: str
    cfmpm: str
    held: str
    test: str


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
    """
    head = [field.name for field in fields(Claim)]
    rows = [astuple(claim) for claim in claims]
    with Path(table).open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *rows])
    lines = [head, ["---"] * len(head), *rows]
    Path(markdown).write_text(
        "".join(f"| {' | '.join(line)} |\n" for line in lines), encoding="utf-8"
    )
    Path(page).write_text(_page(title, head, rows), encoding="utf-8")


def _page(title: str, head: list[str], rows: list[tuple[str, ...]]) -> str:
    def line(cells: tuple[str, ...] | list[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(c)}</{tag}>" for c in cells) + "</tr>\n"

    return (
        f'<!DOCTYPE html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title>\n'
        "<style>body{font:14px sans-serif}table{border-collapse:collapse}"
        "td,th{border:1px solid #bbb;padding:4px 8px;text-align:left;vertical-align:top}</style>\n"
        f"<table>\n{line(head, 'th')}{''.join(line(row, 'td') for row in rows)}</table></html>\n"
    )
