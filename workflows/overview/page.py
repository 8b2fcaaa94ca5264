"""One page of the reproduction: each figure beside its claims, and every claim with its verdict."""

from __future__ import annotations

import csv
import html
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from workflows.reporting.claim_table import Claim, claims_table, read_table
from workflows.reporting.html_page import html_image, html_page, write_text

# Beside a figure; by what a claim was decided stands in the table of all.
BESIDE = ("claim", "paper", "reference", "cfmpm", "error", "held")
# In which order verdicts are counted, and what they are called then.
VERDICTS = {"yes": "held", "in part": "held in part", "no": "did not hold", "misprint": "misprints"}


def write_overview(
    sections: Mapping[str, Mapping[str, Any]], tables: Mapping[str, str | Path], page: str | Path
) -> None:
    """Write the page; pictures are inside it.

    Parameters
    ----------
    sections : mapping of str to mapping
        By title: ``figures`` and ``captions``, paths of PNG and text files by their numbers in the
        paper, and ``benchmarks``, the files of what Snakemake has measured of the jobs behind them,
        by their names.
    tables : mapping of str to Path
        By title: CSV files of `claim_table.write_table`.
    page : Path
    """
    claims = {title: read_table(path) for title, path in tables.items()}
    every = [claim for of_table in claims.values() for claim in of_table]
    parts = [_summary(every)]
    for title, section in sections.items():
        parts.append(f"<h2>{html.escape(title)}</h2>\n<p>{_time(section['benchmarks'])}</p>\n")
        for number, picture in section["figures"].items():
            seen = [claim for claim in every if str(number) in claim.figures.split()]
            caption = Path(section["captions"][number]).read_text(encoding="utf-8")
            parts.append(_figure(str(number), Path(picture), caption, seen))
    parts.append("<h2>Every claim</h2>\n")
    for title, of_table in claims.items():
        parts.append(f"<h3>{html.escape(title)}</h3>\n{claims_table(of_table)}")
    write_text(html_page("The paper, reproduced", "".join(parts)), page)


def _summary(claims: Sequence[Claim]) -> str:
    """How many claims held; those that did not, said plainly."""
    counts = Counter(claim.verdict for claim in claims)
    said = ", ".join(f"{counts[v]} {name}" for v, name in VERDICTS.items() if counts[v])
    text = f"<p>{len(claims)} claims and numbers of section 5: {said}.</p>\n"
    for verdict, title in (
        ("misprint", "Misprints: the paper's words do not fit its own numbers"),
        ("no", "Did not hold"),
        ("in part", "Held in part"),
    ):
        lines = "".join(
            f"<li>{html.escape(claim.claim)}: {html.escape(_found(claim))}</li>\n"
            for claim in claims
            if claim.verdict == verdict
        )
        text += f"<h3>{title}</h3>\n<ul>\n{lines}</ul>\n" if lines else ""
    return text


def _found(claim: Claim) -> str:
    """What was found against what was said, in a line."""
    told = [("paper", claim.paper), ("reference", claim.reference), ("here", claim.cfmpm)]
    told.append(("error", claim.error))
    return "; ".join(f"{who}: {what}" for who, what in told if what)


def _figure(number: str, picture: Path, caption: str, claims: Sequence[Claim]) -> str:
    """A picture with its caption and the claims that are seen in it."""
    return (
        f'<figure id="{picture.stem}">\n{html_image(picture, f"Fig. {number}")}\n<figcaption>'
        f"<b>Fig. {html.escape(number)}.</b> {html.escape(' '.join(caption.split()))}\n"
        f"{claims_table(claims, BESIDE) if claims else ''}</figcaption>\n</figure>\n"
    )


def _time(benchmarks: Mapping[str, str | Path]) -> str:
    """Wall time of the jobs of a section."""
    seconds = {}
    for job, path in benchmarks.items():
        with Path(path).open(newline="", encoding="utf-8") as file:
            (row,) = csv.DictReader(file, delimiter="\t")
        seconds[job] = float(row["s"])
    each = ", ".join(f"{job} {s:.0f} s" for job, s in seconds.items())
    return f"Wall time: {sum(seconds.values()):.0f} s ({html.escape(each)})."
