"""The overview: what holds and what does not, figures with what they are made from, every claim."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from page_parts import Page, write_moving, write_picture, write_time

from workflows.overview.page import DOI, write_overview
from workflows.reporting.claim_table import Claim, write_table

RISES = Claim(
    claim="CF rises",
    paper="It rises",
    reference="order h",
    found="order h^1.10",
    held="yes",
    test="each grid",
    error="3e-12",
    figures="4",
    sentence="CF rises.",
    best="order h^2",
    key="rises",
    section="5.1",
    page="8",
)
CLAIMS = [
    RISES,
    replace(RISES, claim="K_I is low", held="no", figures="4 5", sentence="K_I is high."),
    replace(RISES, claim="CF rises on T6", figures="5"),
    replace(
        RISES, claim="The crack is straight", held="in part", figures="9", sentence="It bends."
    ),
    replace(RISES, claim="R is a/20", held="misprint", figures="9", sentence="R is a/2."),
    replace(RISES, claim="It ends", held="yes, at last", figures="9", sentence=""),
    replace(RISES, claim="It was seen", held="not tested", figures="9", sentence="No data."),
    Claim("5.2 Energy", "", "work", "balance", "yes", "a test", figures="further_on"),
    Claim("5.1 Another law", "", "", "as well", "no", "a test"),
]


@pytest.fixture
def parts(tmp_path):
    """Two sections with their files, and the tables of their claims."""
    results, configs = tmp_path / "results/paper", tmp_path / "configs"
    configs.mkdir()

    def section(numbers, films=(), extra=()):
        for number in numbers:
            write_picture(results / f"fig{number}.png")
            (results / f"fig{number}.nc").touch()
            caption = configs / f"fig{number}.rst"
            caption.write_text(f"Plainly {number}.\n\nIn\ndetail {number}.\n", encoding="utf-8")
        for name in extra:
            write_picture(results / f"{name}.png")
            (results / f"{name}.nc").touch()
            (configs / f"{name}.rst").write_text("We went on.\n", encoding="utf-8")
        for film in films:
            write_moving(results / f"film_{film}.png")
            write_moving(results / f"{film}.gif")
            (configs / "film.rst").write_text("It moves.\n", encoding="utf-8")
        for name, seconds in (("data", 12.4), ("drawing", 3.0)):
            write_time(configs / f"{name}.tsv", seconds)
        (configs / "scene.yaml").touch()
        return {
            "figures": {
                number: {
                    "title": f"title {number}",
                    "paper": f"paper {number}",
                    "picture": str(results / f"fig{number}.png"),
                    "data": str(results / f"fig{number}.nc"),
                    "caption": str(configs / f"fig{number}.rst"),
                }
                for number in numbers
            }
            | {
                name: {
                    "title": f"title {name}",
                    "paper": "",
                    "picture": str(results / f"{name}.png"),
                    "data": str(results / f"{name}.nc"),
                    "caption": str(configs / f"{name}.rst"),
                }
                for name in extra
            },
            "films": [
                {
                    "title": "growth",
                    "picture": str(results / f"film_{film}.png"),
                    "file": str(results / f"{film}.gif"),
                    "caption": str(configs / "film.rst"),
                }
                for film in films
            ],
            "benchmarks": {
                "computation": [str(configs / "data.tsv")],
                "figures": [str(configs / "drawing.tsv")],
            },
            "scene": str(configs / "scene.yaml"),
            "study": str(configs / "scene.yaml"),
        }

    return {
        "5.1 At rest": section(["4", "5"]),
        "5.2 Growing": section(["9"], ["edge"], ["further_on"]),
    }


@pytest.fixture
def pages(parts, tmp_path):
    """The page, and the one for the report."""

    def write(claims=CLAIMS):
        table, other, third = (tmp_path / f"claims.{kind}" for kind in ("csv", "md", "html"))
        write_table(claims, "claims", table, other, third)
        paths = [tmp_path / "results/paper" / f"{name}.html" for name in ("overview", "summary")]
        write_overview(parts, [table], *paths)
        return [Page.of_file(path) for path in paths]

    return write


def test_the_first_screen_counts_claims_of_the_paper_and_says_in_sentences(pages):
    for page in pages():
        assert (
            "Of 7 claims of the paper, computed by its own method, 3 hold, 1 holds in part, "
            "1 does not hold, 1 is a misprint, and 1 is not tested." in page.text
        )
        # Found alike, said once, with links to both; without a sentence the claim stands for it.
        assert "Holds (3) 5.1 CF rises. 1, 3 5.2 It ends. 6" in page.text
        assert "Does not hold (1) 5.1 KI is high. 2" in page.text
        assert "Misprints of the paper (1) 5.2 R is a/2. 5" in page.text
        assert "Not tested (1) 5.2 No data. 7" in page.text
        assert "Beyond the paper 1 of 2 checks hold" in page.text
    page, _ = pages([RISES])
    assert "Of 1 claims of the paper, computed by its own method, 1 holds." in page.text
    page, _ = pages([RISES, replace(RISES, held="no")])
    assert "1 holds and 1 does not hold." in page.text


def test_each_claim_stands_once_in_its_section(pages):
    for page in pages():
        assert [one for one in page.places if re.fullmatch(r"(claim|beyond)-\d+", one)] == [
            *(f"claim-{k}" for k in range(1, 4)),
            "beyond-1",
            *(f"claim-{k}" for k in range(4, 8)),
            "beyond-2",
        ]
        for claim in (
            "KI is low",
            "CF rises on T6",
            "The crack is straight",
            "R is a/20",
            "Energy",
        ):
            assert page.text.count(claim) == 1
        # What the paper states, with its place, and numbers as in print.
        assert (
            "It rises (section 5.1, page 8) order h1.10 order h2 order h 3 × 10−12 yes each grid"
            in page.text
        )
        assert page.text.index("CF rises on T6") < page.text.index("The crack is straight")
        # Beyond the paper nothing is said of it.
        assert "5.1 Another law as well no a test" in page.text
        assert page.text.index("R is a/20") < page.text.index(
            "5.2 Energy work balance yes a test further on"
        )


def test_figures_stand_beside_what_they_are_made_from(pages, tmp_path):
    page, summary = pages()
    assert page.pictures == [
        "Fig. 4: title 4",
        "Fig. 5: title 5",
        "Fig. 9: title 9",
        "Beyond the paper: title further_on",
        "Film: growth",
    ]
    assert (
        "Fig. 4: title 4 Plainly 4. In the paper: paper 4. In detail 4. Data: fig4.nc." in page.text
    )
    assert "Beyond the paper: title further_on We went on. Data: further_on.nc." in page.text
    assert "Scene: scene.yaml. Study: scene.yaml." in page.text
    assert page.text.count("Wall time of the section: 15 s (computation 12 s, figures 3 s).") == 5
    assert {"fig4.png", "fig4.nc", "edge.gif", "../../configs/scene.yaml", DOI} <= {*page.links}
    assert "Zhou" in page.text
    assert summary.pictures == []


def test_every_link_leads_somewhere(pages, tmp_path):
    for page in pages():
        assert len(page.places) == len(set(page.places))
        for link in page.links:
            if link.startswith("#"):
                assert link[1:] in page.places
            elif link != DOI:
                assert (tmp_path / "results/paper" / link).is_file()
    page, summary = pages()
    assert {
        "#verdict",
        "#5-1-at-rest",
        "#fig-9",
        "#film_edge",
        "#claims-5-2-growing",
        "#further_on",
    } <= {*page.links}
    # In the report, which has the page inside itself, no file is beside it.
    assert all(link.startswith("#") for link in summary.links)


def test_a_claim_of_no_section_is_refused(pages):
    with pytest.raises(ValueError, match=r"no section: the claim '5\.9 Else'"):
        pages([replace(RISES, claim="5.9 Else", figures="")])


def test_a_verdict_that_no_page_knows_is_refused():
    with pytest.raises(ValueError, match="CF rises: unknown verdict: perhaps"):
        replace(RISES, held="perhaps")


def test_pages_are_small_enough_for_the_report(pages, tmp_path):
    """A browser shows no page inside another one of more than two million characters."""
    pages([replace(RISES, claim=f"{RISES.claim} {k}") for k in range(300)])
    size = (tmp_path / "results/paper/summary.html").stat().st_size
    assert 4 / 3 * size < 2_000_000
