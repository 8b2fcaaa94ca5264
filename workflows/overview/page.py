"""The reproduction on one page: what holds and what does not, figures, films and every claim."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from workflows.overview.contents import Numbered, Picture, Section, read_sections
from workflows.overview.style import BESIDE, STYLE
from workflows.reporting.claim_table import SHOWN, Claim, cells, mark
from workflows.reporting.html_page import html_image, html_page, html_text, write_text

TITLE = "The paper, reproduced"
PAPER = (
    "R. Zhou, W. M. Coombs, Y. Xu, P. Zhang, L.-G. Wang, “A configurational force-based material "
    "point method for crack propagation modelling in 2D”, Theoretical and Applied Fracture "
    "Mechanics 117 (2022) 103186, "
)
DOI = "https://doi.org/10.1016/j.tafmec.2021.103186"
TERMS = (
    "CF: configurational force. MPM: material point method. FEM: finite element method. T3, T6: "
    "triangles of three and of six nodes. G, J: energy release rate and J-integral. R: radius of "
    "the domain over which CF is summed."
)
# Verdicts in the order of the page: how many of them are told, and how they are headed.
VERDICTS = {
    "yes": ("{} holds", "{} hold", "Holds"),
    "no": ("{} does not hold", "{} do not hold", "Does not hold"),
    "in part": ("{} holds in part", "{} hold in part", "Holds in part"),
    "misprint": ("{} is a misprint", "{} are misprints", "Misprints of the paper"),
}


def write_overview(
    sections: Mapping[str, Mapping[str, Any]],
    tables: Sequence[str | Path],
    page: str | Path,
    summary: str | Path,
) -> None:
    """Write the page, and the same without pictures.

    Parameters
    ----------
    sections : mapping of str to mapping
        By title, as `contribute` of the rules collects them.
    tables : sequence of Path
        CSV files of `claim_table.write_table`.
    page : Path
        Images are inside; it links to the files from which and as which they were made.
    summary : Path
        Without figures and links to files, for Snakemake's report: browsers show no page inside
        another one that is larger than some two million characters.
    """
    found = read_sections(sections, tables)
    first = _first_screen([claim for section in found for claim in section.claims])
    folder = Path(page).parent
    whole = "".join(_section(section, folder) for section in found)
    body = f"<main>\n{_citation()}{first}{_contents(found)}{whole}</main>\n"
    write_text(html_page(TITLE, body, STYLE + BESIDE), page)
    claims = "".join(
        f"<h2>{html.escape(section.title)}</h2>\n{_claims(section.claims)}"
        for section in found
        if section.claims
    )
    write_text(html_page("What holds and what does not", f"{first}{claims}", STYLE), summary)


def _citation() -> str:
    link = f'<a href="{DOI}">{DOI.removeprefix("https://")}</a>'
    return f'<p class="source">{html.escape(PAPER)}{link}. Open access, CC BY.</p>\n'


def _first_screen(claims: Sequence[Numbered]) -> str:
    """How many claims hold, and what was found, in plain sentences."""
    of = {name: [one for one in claims if one.claim.verdict == name] for name in VERDICTS}
    unknown = {one.claim.verdict for one in claims} - of.keys()
    if unknown:
        raise ValueError(f"unknown verdict: {', '.join(sorted(unknown))}")
    counts = [
        (one if len(of[verdict]) == 1 else several).format(len(of[verdict]))
        for verdict, (one, several, _) in VERDICTS.items()
        if of[verdict]
    ]
    listed = {
        verdict: f"<h3>{title} ({len(of[verdict])})</h3>\n{_sentences(of[verdict], verdict)}"
        for verdict, (*_, title) in VERDICTS.items()
        if of[verdict]
    }
    said = counts[0] if len(counts) == 1 else f"{', '.join(counts[:-1])}, and {counts[-1]}"
    holds = listed.pop("yes", "")
    return (
        f'<section id="verdict">\n<p class="lead">Of {len(claims)} claims and numbers of section '
        f"5, {said}.</p>\n"
        f'<div class="columns"><div>{"".join(listed.values())}</div><div>{holds}</div></div>\n'
        f'<p class="source">{html.escape(TERMS)}</p>\n</section>\n'
    )


def _sentences(claims: Iterable[Numbered], verdict: str) -> str:
    """One line for all claims that were found alike, with links to them."""
    alike: dict[tuple[str, str], list[int]] = {}
    for one in claims:
        sentence = one.claim.sentence or f"{one.claim.claim}."
        alike.setdefault((one.section, sentence), []).append(one.number)
    lines = ""
    for (section, sentence), numbers in alike.items():
        links = ", ".join(f'<a href="#claim-{number}">{number}</a>' for number in numbers)
        lines += f"<li><b>{section}</b> {html_text(sentence)} <span>{links}</span></li>\n"
    return f'<ul class="{verdict.replace(" ", "-")}">\n{lines}</ul>\n'


def _contents(sections: Sequence[Section]) -> str:
    """Links to all sections and figures."""
    lines = '<li><a href="#verdict">What holds and what does not</a></li>\n'
    for section in sections:
        inside = "".join(
            f'<li><a href="#{_place(one)}">{html.escape(f"{one.name}: {one.title}")}</a></li>\n'
            for one in section.pictures
        )
        if section.claims:
            inside += f'<li><a href="#claims-{_slug(section.title)}">Claims</a></li>\n'
        lines += (
            f'<li><a href="#{_slug(section.title)}">{html.escape(section.title)}</a>\n'
            f"<ul>\n{inside}</ul></li>\n"
        )
    return f'<nav aria-label="Contents">\n<ul>\n{lines}</ul>\n</nav>\n'


def _section(section: Section, folder: Path) -> str:
    slug = _slug(section.title)
    each = ", ".join(f"{done} {seconds:.0f} s" for done, seconds in section.seconds.items())
    time = f"{sum(section.seconds.values()):.0f} s ({html.escape(each)})"
    made_from = (
        f"Scene: {_link(section.scene, folder)}. Study: {_link(section.study, folder)}. "
        f"Wall time of the section: {time}."
    )
    pictures = "".join(_picture(one, made_from, folder) for one in section.pictures)
    claims = f'<h3 id="claims-{slug}">Claims</h3>\n{_claims(section.claims, figures=True)}'
    return (
        f'<section id="{slug}">\n<h2>{html.escape(section.title)}</h2>\n{pictures}'
        f"{claims if section.claims else ''}</section>\n"
    )


def _picture(one: Picture, made_from: str, folder: Path) -> str:
    """A figure beside its caption, and what it was made from."""
    first, *others = one.sentences
    link = _from(folder, one.file)
    image = html_image(one.picture, f"{one.name}: {one.title}")
    paper = f'<p class="paper">In the paper: {html_text(one.paper)}.</p>\n' if one.paper else ""
    data = f"Data: {_link(one.data, folder)}. " if one.data else ""
    return (
        f'<figure id="{_place(one)}">\n<a href="{link}">{image}</a>\n<figcaption>\n'
        f"<h3>{html.escape(f'{one.name}: {one.title}')}</h3>\n"
        f'<p class="plain">{html_text(first)}</p>\n{paper}'
        + "".join(f"<p>{html_text(other)}</p>\n" for other in others)
        + f'<p class="source">{data}{made_from}</p>\n'
        "</figcaption>\n</figure>\n"
    )


def _claims(claims: Sequence[Numbered], *, figures: bool = False) -> str:
    """The claims of a section, each with its number; with links to their figures or without."""
    head = "".join(f"<th>{name}</th>" for name in ("", *SHOWN.values(), "Fig."))
    rows = "".join(
        f'<tr id="claim-{one.number}" class="{mark(one.claim)}"><td>{one.number}</td>'
        + "".join(f"<td>{html_text(cell)}</td>" for cell in cells(one.claim))
        + f"<td>{_of_figures(one.claim, linked=figures)}</td></tr>\n"
        for one in claims
    )
    return f"<table>\n<tr>{head}</tr>\n{rows}</table>\n"


def _of_figures(claim: Claim, *, linked: bool) -> str:
    if not linked:
        return html.escape(claim.figures)
    return " ".join(f'<a href="#fig-{n}">{html.escape(n)}</a>' for n in claim.figures.split())


def _link(path: Path, folder: Path) -> str:
    return f'<a href="{_from(folder, path)}">{html.escape(path.name)}</a>'


def _from(folder: Path, path: Path) -> str:
    """The address of a file on a page in a folder."""
    return html.escape(Path(os.path.relpath(path, folder)).as_posix())


def _place(one: Picture) -> str:
    """Where a figure or film is on the page: fig-9, or by the name of its file."""
    return _slug(one.name) if one.paper else one.picture.stem


def _slug(text: str) -> str:
    return re.sub(r"\W+", "-", text).strip("-").lower()
