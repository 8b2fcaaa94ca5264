"""The reproduction on one page: what holds and what does not, figures, films and every claim."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from workflows.overview.contents import Numbered, Picture, Section, place_of, read_sections
from workflows.overview.style import BESIDE, STYLE
from workflows.reporting.claim_table import BEYOND, OF_THE_PAPER, Claim, cells, mark
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
    "in part": ("{} holds in part", "{} hold in part", "Holds in part"),
    "no": ("{} does not hold", "{} do not hold", "Does not hold"),
    "misprint": ("{} is a misprint", "{} are misprints", "Misprints of the paper"),
    "not tested": ("{} is not tested", "{} are not tested", "Not tested"),
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
    first = _first_screen(found)
    folder = Path(page).parent
    whole = "".join(_section(section, folder) for section in found)
    body = f"<main>\n{_citation()}{first}{_contents(found)}{whole}</main>\n"
    write_text(html_page(TITLE, body, STYLE + BESIDE), page)
    claims = "".join(
        f"<h2>{html.escape(section.title)}</h2>\n{_tables(section, figures=False)}"
        for section in found
        if section.claims or section.beyond
    )
    write_text(html_page("What holds and what does not", f"{first}{claims}", STYLE), summary)


def _citation() -> str:
    link = f'<a href="{DOI}">{DOI.removeprefix("https://")}</a>'
    return f'<p class="source">{html.escape(PAPER)}{link}. Open access, CC BY.</p>\n'


def _first_screen(sections: Sequence[Section]) -> str:
    """How many claims hold, and what was found, in plain sentences."""
    claims = [one for section in sections for one in section.claims]
    of = {name: [one for one in claims if one.claim.verdict == name] for name in VERDICTS}
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
    return (
        f'<section id="verdict">\n<p class="lead">Of {len(claims)} claims of the paper, '
        f"computed by its own method, {_series(counts)}.</p>\n"
        f'<div class="columns">{"".join(listed.values())}</div>\n'
        f'<p class="source">{_beyond(sections)}{html.escape(TERMS)}</p>\n</section>\n'
    )


def _series(words: Sequence[str]) -> str:
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])}{',' if len(words) > 2 else ''} and {words[-1]}"


def _beyond(sections: Sequence[Section]) -> str:
    """How many findings there are beyond the paper."""
    found = [one.claim.verdict for section in sections for one in section.beyond]
    if not found:
        return ""
    held = found.count("yes")
    return f"Beyond the paper {held} of {len(found)} checks hold; they follow the claims. "


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
            f'<li><a href="#{one.place}">{html.escape(f"{one.name}: {one.title}")}</a></li>\n'
            for one in section.pictures
        )
        for kind, claims, title in (
            ("claims", section.claims, "Claims of the paper"),
            ("beyond", section.beyond, "Beyond the paper"),
        ):
            if claims:
                inside += f'<li><a href="#{kind}-{_slug(section.title)}">{title}</a></li>\n'
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
    return (
        f'<section id="{slug}">\n<h2>{html.escape(section.title)}</h2>\n{pictures}'
        f"{_tables(section, figures=True)}</section>\n"
    )


def _tables(section: Section, *, figures: bool) -> str:
    """Claims of the paper, and what is beyond it; with links to their figures or without."""
    slug, text = _slug(section.title), ""
    if section.claims:
        text += f'<h3 id="claims-{slug}">Claims of the paper</h3>\n'
        text += _claims(section.claims, OF_THE_PAPER, "claim", figures)
    if section.beyond:
        text += f'<h3 id="beyond-{slug}">Beyond the paper</h3>\n'
        text += _claims(section.beyond, BEYOND, "beyond", figures)
    return text


def _picture(one: Picture, made_from: str, folder: Path) -> str:
    """A figure beside its caption, and what it was made from."""
    first, *others = one.sentences
    link = _from(folder, one.file)
    image = html_image(one.picture, f"{one.name}: {one.title}")
    paper = f'<p class="paper">In the paper: {html_text(one.paper)}.</p>\n' if one.paper else ""
    data = f"Data: {_link(one.data, folder)}. " if one.data else ""
    return (
        f'<figure id="{one.place}">\n<a href="{link}">{image}</a>\n<figcaption>\n'
        f"<h3>{html.escape(f'{one.name}: {one.title}')}</h3>\n"
        f'<p class="plain">{html_text(first)}</p>\n{paper}'
        + "".join(f"<p>{html_text(other)}</p>\n" for other in others)
        + f'<p class="source">{data}{made_from}</p>\n'
        "</figcaption>\n</figure>\n"
    )


def _claims(
    claims: Sequence[Numbered], columns: Mapping[str, str], kind: str, figures: bool
) -> str:
    """Claims, each with its number; with links to their figures or without."""
    head = "".join(f"<th>{name}</th>" for name in ("", *columns.values(), "Fig."))
    rows = "".join(
        f'<tr id="{kind}-{one.number}" class="{mark(one.claim)}"><td>{one.number}</td>'
        + "".join(f"<td>{html_text(cell)}</td>" for cell in cells(one.claim))
        + f"<td>{_of_figures(one.claim, linked=figures)}</td></tr>\n"
        for one in claims
    )
    return f"<table>\n<tr>{head}</tr>\n{rows}</table>\n"


def _of_figures(claim: Claim, *, linked: bool) -> str:
    if not linked:
        return html.escape(claim.figures)
    return " ".join(
        f'<a href="#{place_of(name)}">{html.escape(name)}</a>' for name in claim.figures.split()
    )


def _link(path: Path, folder: Path) -> str:
    return f'<a href="{_from(folder, path)}">{html.escape(path.name)}</a>'


def _from(folder: Path, path: Path) -> str:
    """The address of a file on a page in a folder."""
    return html.escape(Path(os.path.relpath(path, folder)).as_posix())


def _slug(text: str) -> str:
    return re.sub(r"\W+", "-", text).strip("-").lower()
