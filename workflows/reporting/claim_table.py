"""The table of a section: what the paper says, what is known otherwise, what was computed."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from cfmpm.output.files import written_aside
from workflows.reporting.html_page import html_page, html_table, write_text

# Of the table to be read, and how its columns are headed; the CSV file has all fields.
SHOWN = {
    "claim": "claim",
    "paper": "the paper",
    "reference": "what is known otherwise",
    "cfmpm": "found here",
    "error": "error",
    "held": "held",
    "test": "decided by",
}


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
    sentence : str
        What was found, in one plain sentence. Claims that were found alike have the same.
    """

    claim: str
    paper: str
    reference: str
    cfmpm: str
    held: str
    test: str
    error: str = ""
    figures: str = ""
    sentence: str = ""

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
    lines = [SHOWN.values(), ["---"] * len(SHOWN), *(cells(claim) for claim in claims)]
    write_text("".join(f"| {' | '.join(line)} |\n" for line in lines), markdown)
    write_text(html_page(title, claims_table(claims)), page)


def read_table(path: str | Path) -> list[Claim]:
    """Read the claims of a CSV file back."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return [Claim(**row) for row in csv.DictReader(file)]


def claims_table(claims: Iterable[Claim]) -> str:
    """Return claims as an HTML table, one row each below a head."""
    claims = list(claims)
    marks = [mark(claim) for claim in claims]
    return html_table(list(SHOWN.values()), map(cells, claims), marks)


def cells(claim: Claim) -> list[str]:
    """What the table shows of a claim."""
    return [getattr(claim, name) for name in SHOWN]


def mark(claim: Claim) -> str:
    """The class of a claim's row in a page's style."""
    return claim.verdict.replace(" ", "-")
