"""The whole paper from a clean clone, twice."""

from __future__ import annotations

import csv
import re
import subprocess

import pytest
from headless_chromium import Browser
from page_parts import Page, program_words
from walk_through import walk_through_overview, walk_through_report

from workflows.reporting.claim_table import read_table
from workflows.reporting.html_page import html_text
from workflows.reporting.statements import statements

pytestmark = pytest.mark.slow

FIGURES = tuple(range(4, 17))
# Beyond the paper.
EXTRA = (
    *("error_by_unknowns", "large_strain_laws"),
    *("convergence_shear", "driving_force_holes", "near_miss_beam"),
    *("scatter_edge", "scatter_shear", "scatter_holes", "scatter_beam"),
)
TABLES = ("section_5_1", "sections_5_2_to_5_5", "large_strain")
STUDIES = ("edge", "shear", "holes", "beam")
EVERYTHING = [
    *(f"fig{n}.{kind}" for n in FIGURES for kind in ("nc", "png")),
    *(f"{name}.{kind}" for name in EXTRA for kind in ("nc", "png")),
    *(f"growth/{study}.nc" for study in STUDIES),
    *(name for study in STUDIES for name in (f"{study}.gif", f"film_{study}.png")),
    *(f"{table}.{kind}" for table in TABLES for kind in ("csv", "md", "html")),
    "overview.html",
    "summary.html",
]


@pytest.fixture(scope="module")
def reproduced(root, tmp_path_factory, snakemake):
    """A clean clone of HEAD with all results, made with an empty kernel cache."""
    folder = tmp_path_factory.mktemp("clone")
    subprocess.run(["git", "clone", "-q", str(root), str(folder)], check=True)
    environment = {"NUMBA_CACHE_DIR": str(folder / ".numba")}
    snakemake("reproduce-paper", folder=folder, **environment)
    return folder, environment


def test_everything_is_there(reproduced):
    folder, _ = reproduced
    for name in EVERYTHING:
        assert (folder / "results/paper" / name).stat().st_size > 0


def test_two_jobs_side_by_side_fit_in_4_gb(reproduced):
    peaks = []
    for path in (reproduced[0] / "results/benchmarks").rglob("*.tsv"):
        with path.open(newline="", encoding="utf-8") as file:
            peaks += [row["max_rss"] for row in csv.DictReader(file, delimiter="\t")]
    # Of a job that ends at once nothing is measured.
    first, second, *_ = sorted((float(mb) for mb in peaks if mb not in ("NA", "-")), reverse=True)
    assert min(first, second) > 100
    assert first + second < 4096


def test_second_call_does_nothing(reproduced, snakemake):
    folder, environment = reproduced
    done = snakemake("reproduce-paper", folder=folder, **environment)
    assert "Nothing to be done" in done.stdout + done.stderr


def test_report(reproduced, snakemake):
    folder, environment = reproduced
    snakemake("reproduce-paper", "--report", "report.html", folder=folder, **environment)
    text = (folder / "report.html").read_text(encoding="utf-8")
    for name in EVERYTHING:
        assert name in text or not name.endswith((".png", ".html")) or name == "overview.html"


def test_report_and_overview_in_a_browser(reproduced, snakemake, tmp_path):
    folder, environment = reproduced
    browser = Browser(tmp_path)
    try:
        walk_through_overview(browser, folder / "results/paper/overview.html")
        snakemake("reproduce-paper", "--report", "report.html", folder=folder, **environment)
        found = walk_through_report(browser, folder / "report.html")
    finally:
        browser.close()
    assert (
        sum(map(len, found.values())) == len(FIGURES) + len(EXTRA) + len(STUDIES) + len(TABLES) + 1
    )


def test_overview_has_every_figure_and_claim(reproduced):
    paper = reproduced[0] / "results/paper"
    page = Page.of_file(paper / "overview.html")
    figures = [one.split(":")[0] for one in page.pictures if one.startswith("Fig.")]
    assert figures == [f"Fig. {n}" for n in FIGURES]
    assert len(page.pictures) == len(FIGURES) + len(EXTRA) + len(STUDIES)
    claims = [claim for table in TABLES for claim in read_table(paper / f"{table}.csv")]
    of_the_paper = [one for one in claims if one.key]
    numbers = {"claim": len(of_the_paper), "beyond": len(claims) - len(of_the_paper)}
    for kind, number in numbers.items():
        rows = [one for one in page.places if re.fullmatch(rf"{kind}-\d+", one)]
        assert sorted(rows) == sorted(f"{kind}-{k + 1}" for k in range(number))
    assert f"Of {len(of_the_paper)} claims of the paper" in page.text
    for claim in claims:
        assert not claim.key or Page(html_text(claim.sentence)).text in page.text
        assert Page(html_text(claim.claim)).text in page.text
    assert program_words(page.text) == []
    for link in page.links:
        assert link.startswith(("#", "https://doi.org/")) or (paper / link).is_file()


def test_verdicts_are_those_of_the_list_of_statements(reproduced):
    """docs/paper.md says of each claim what the datasets say."""
    paper = reproduced[0] / "results/paper"
    claims = [one for table in TABLES for one in read_table(paper / f"{table}.csv") if one.key]
    decided = {one.key: one.verdict for one in claims}
    assert len(decided) == len(claims)
    sections = {one.section for one in claims}
    listed = [one for one in statements().values() if one.figures and one.section in sections]
    assert decided == {one.key: one.held for one in listed}
