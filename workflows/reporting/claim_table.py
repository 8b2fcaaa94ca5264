"""The table of a section: what the paper says, what is known otherwise, what was computed."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from cfmpm.output.files import written_aside
from workflows.reporting.html_page import html_page, html_table, write_text

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
    write_text(html_page(title, claims_table(claims)), page)


def read_table(path: str | Path) -> list[Claim]:
    """Read the claims of a CSV file back."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return [Claim(**row) for row in csv.DictReader(file)]


def claims_table(claims: Iterable[Claim], columns: Sequence[str] = SHOWN) -> str:
    """Return claims as an HTML table, one row each below a head."""
    claims = list(claims)
    rows = [_cells(claim, columns) for claim in claims]
    return html_table(columns, rows, [claim.verdict.replace(" ", "-") for claim in claims])


def _cells(claim: Claim, columns: Sequence[str] = SHOWN) -> list[str]:
    return [getattr(claim, name) for name in columns]
