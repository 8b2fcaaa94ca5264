"""What the overview shows: the sections of the paper with their figures, films and claims."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workflows.reporting.claim_table import Claim, read_table


@dataclass(frozen=True)
class Picture:
    """A figure or a film.

    Attributes
    ----------
    name : str
        As Fig. 9, Film, or Beyond the paper.
    place : str
        Of the picture on the page.
    title : str
        What it shows.
    paper : str
        What the paper's figure of this number shows; nothing for what the paper has not.
    picture : Path
        PNG.
    file : Path
        What opens at a click: the same, or the film as a file to be kept.
    data : Path or None
        netCDF.
    sentences : list of str
        The caption by its paragraphs; the first is one plain sentence.
    """

    name: str
    place: str
    title: str
    paper: str
    picture: Path
    file: Path
    data: Path | None
    sentences: list[str]


@dataclass(frozen=True)
class Numbered:
    """A claim with its number on the page and that of its section, as 5.2.

    Claims of the paper are numbered by themselves, and so is what is beyond it.
    """

    number: int
    section: str
    claim: Claim


@dataclass(frozen=True)
class Section:
    """A section of the paper.

    Attributes
    ----------
    title : str
    pictures : list of Picture
    claims, beyond : list of Numbered
        Claims of the paper, and what is beyond it.
    scene, study : Path
    seconds : dict of str to float
        Wall time by what was done.
    """

    title: str
    pictures: list[Picture]
    claims: list[Numbered]
    beyond: list[Numbered]
    scene: Path
    study: Path
    seconds: dict[str, float]


def read_sections(
    sections: Mapping[str, Mapping[str, Any]], tables: Sequence[str | Path]
) -> list[Section]:
    """Read what the sections are made of.

    Parameters
    ----------
    sections : mapping of str to mapping
        By title, as `contribute` of the rules collects them.
    tables : sequence of Path
        CSV files of `claim_table.write_table`.

    Raises
    ------
    ValueError
        If a claim belongs to no section.
    """
    every = [claim for path in tables for claim in read_table(path)]
    homes = [_home(claim, sections) for claim in every]
    found: list[Section] = []
    for title, parts in sections.items():
        own = [claim for claim, home in zip(every, homes, strict=True) if home == title]
        found.append(
            Section(
                title,
                [_figure(n, figure) for n, figure in parts["figures"].items()]
                + [_film(film) for film in parts["films"]],
                _numbered(title, [c for c in own if c.key], sum(len(s.claims) for s in found)),
                _numbered(title, [c for c in own if not c.key], sum(len(s.beyond) for s in found)),
                Path(parts["scene"]),
                Path(parts["study"]),
                {
                    done: sum(map(_seconds, together))
                    for done, together in parts["benchmarks"].items()
                },
            )
        )
    return found


def _numbered(title: str, claims: Sequence[Claim], before: int) -> list[Numbered]:
    return [Numbered(k, title.split()[0], claim) for k, claim in enumerate(claims, before + 1)]


def _home(claim: Claim, sections: Mapping[str, Mapping[str, Any]]) -> str:
    """The section that has the first figure of a claim, or whose number the claim begins with."""
    for title, parts in sections.items():
        if claim.figures and claim.figures.split()[0] in map(str, parts["figures"]):
            return title
    for title in sections:
        if claim.claim.split()[0] == title.split()[0]:
            return title
    raise ValueError(f"in no section: the claim {claim.claim!r}")


def _figure(number: object, figure: Mapping[str, Any]) -> Picture:
    picture = Path(figure["picture"])
    of_the_paper = bool(figure["paper"])
    return Picture(
        name=f"Fig. {number}" if of_the_paper else "Beyond the paper",
        place=place_of(str(number)),
        title=figure["title"],
        paper=figure["paper"],
        picture=picture,
        file=picture,
        data=Path(figure["data"]),
        sentences=_paragraphs(figure["caption"]),
    )


def place_of(figure: str) -> str:
    """Where a figure is on the page: fig-9, or by the name of its file."""
    return f"fig-{figure}" if figure.isdecimal() else figure


def _film(film: Mapping[str, Any]) -> Picture:
    return Picture(
        name="Film",
        place=Path(film["picture"]).stem,
        title=film["title"],
        paper="",
        picture=Path(film["picture"]),
        file=Path(film["file"]),
        data=None,
        sentences=_paragraphs(film["caption"]),
    )


def _paragraphs(caption: str | Path) -> list[str]:
    parts = Path(caption).read_text(encoding="utf-8").split("\n\n")
    return [" ".join(part.split()) for part in parts]


def _seconds(path: str | Path) -> float:
    """Wall time of a job, from the file of what Snakemake has measured of it [s]."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        (row,) = csv.DictReader(file, delimiter="\t")
    return float(row["s"])
