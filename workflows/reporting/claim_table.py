"""The tables of a section: claims of the paper with what was found, and what is beyond it."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from cfmpm.output.files import written_aside
from workflows.reporting.html_page import html_page, html_table, write_text
from workflows.reporting.statements import HELD, statements

# Of the tables to be read, and how their columns are headed; the CSV file has all fields.
OF_THE_PAPER = {
    "claim": "claim",
    "stated": "the paper",
    "found": "by the paper's own method",
    "best": "by the best that can be had",
    "reference": "what is known otherwise",
    "error": "error",
    "held": "held",
    "test": "decided by",
}
BEYOND = {
    "claim": "beyond the paper",
    "reference": "what is known otherwise",
    "found": "found here",
    "error": "error",
    "held": "held",
    "test": "decided by",
}


@dataclass(frozen=True)
class Claim:
    """One line of a table: a claim of the paper, or what was found beyond it.

    `paper_claim` makes a claim of the paper. Without a key a line is beyond the paper.

    Attributes
    ----------
    claim : str
    paper : str
        What the paper states.
    reference, found : str
        What is known otherwise; what was found, of a claim of the paper by its own method.
    held : str
        A word of `statements.HELD`; further words may follow a comma.
    test : str
        By what it was decided.
    error : str
        How far the datasets are from the reference.
    figures : str
        In which figures it is seen: their numbers or names, separated by blanks.
    sentence : str
        What was found, in one plain sentence. Claims that were found alike have the same.
    best : str
        What the best method that can be had gives.
    key : str
        Of `statements`; nothing beyond the paper.
    section : str
        Of the paper.
    page : str
        Of the paper.
    """

    claim: str
    paper: str
    reference: str
    found: str
    held: str
    test: str
    error: str = ""
    figures: str = ""
    sentence: str = ""
    best: str = ""
    key: str = ""
    section: str = ""
    page: str = ""

    def __post_init__(self) -> None:
        if self.verdict not in HELD:
            raise ValueError(f"{self.claim}: unknown verdict: {self.held}")

    @property
    def verdict(self) -> str:
        """The first words of `held`, up to a comma."""
        return self.held.split(",")[0]

    @property
    def stated(self) -> str:
        """What the paper states, and where."""
        return f"{self.paper} (section {self.section}, page {self.page})" if self.page else ""


def paper_claim(
    key: str,
    *,
    found: str,
    held: str,
    test: str,
    sentence: str,
    best: str = "",
    reference: str = "",
    error: str = "",
) -> Claim:
    """Return what became of a statement of the paper, by the paper's own method.

    Parameters
    ----------
    key : str
        Of `statements`, which has what the paper states, where, and the figures that show it.
    found, held, test, sentence, best, reference, error : str
        As in `Claim`.
    """
    one = statements()[key]
    return Claim(
        claim=one.claim,
        paper=one.paper,
        reference=reference,
        found=found,
        held=held,
        test=test,
        error=error,
        figures=one.figures,
        sentence=sentence,
        best=best,
        key=key,
        section=one.section,
        page=str(one.page),
    )


def not_tested(key: str) -> Claim:
    """Return a claim of the paper that is not tested, for the reason that its statement gives."""
    reason = statements()[key].note
    return paper_claim(key, found="", held="not tested", test=reason, sentence=reason)


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
    text = "\n".join(
        f"## {head}\n\n"
        + "".join(
            f"| {' | '.join(line)} |\n"
            for line in (columns.values(), ["---"] * len(columns), *(cells(c) for c in rows))
        )
        for head, columns, rows in tables(claims)
    )
    write_text(text, markdown)
    write_text(html_page(title, claims_tables(claims)), page)


def read_table(path: str | Path) -> list[Claim]:
    """Read the claims of a CSV file back."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return [Claim(**row) for row in csv.DictReader(file)]


def tables(claims: Iterable[Claim]) -> list[tuple[str, dict[str, str], list[Claim]]]:
    """The claims of the paper and what is beyond it: title, columns by field, lines."""
    claims = list(claims)
    parts = (
        ("Claims of the paper", OF_THE_PAPER, [one for one in claims if one.key]),
        ("Beyond the paper", BEYOND, [one for one in claims if not one.key]),
    )
    return [part for part in parts if part[2]]


def claims_tables(claims: Iterable[Claim]) -> str:
    """Return claims as HTML, one row each, those of the paper and the others in tables apart."""
    return "".join(
        f"<h2>{head}</h2>\n"
        + html_table(list(columns.values()), map(cells, rows), [mark(one) for one in rows])
        for head, columns, rows in tables(claims)
    )


def cells(claim: Claim) -> list[str]:
    """What a table shows of a claim."""
    return [getattr(claim, name) for name in (OF_THE_PAPER if claim.key else BEYOND)]


def mark(claim: Claim) -> str:
    """The class of a claim's row in a page's style."""
    return claim.verdict.replace(" ", "-")
