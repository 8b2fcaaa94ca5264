"""The whole paper from a clean clone, twice."""

from __future__ import annotations

import csv
import html.parser
import subprocess

import pytest

from workflows.reporting.claim_table import read_table

pytestmark = pytest.mark.slow

FIGURES = tuple(range(4, 17))
TABLES = ("section_5_1", "sections_5_2_to_5_5", "large_strain")
# Sections 5.1 to 5.5, and Fig. 8.
PARTS = 6
EVERYTHING = [
    *(f"fig{n}.{kind}" for n in FIGURES for kind in ("nc", "png")),
    *(f"growth/{study}.nc" for study in ("edge", "shear", "holes", "beam")),
    *(
        name
        for study in ("edge", "shear", "holes", "beam")
        for name in (f"{study}.gif", f"film_{study}.png")
    ),
    *(f"{table}.{kind}" for table in TABLES for kind in ("csv", "md", "html")),
    "overview.html",
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
        assert name in text or not name.endswith((".png", ".html"))


class Page(html.parser.HTMLParser):
    """Pictures and text of the page."""

    def __init__(self, text):
        super().__init__()
        self.pictures, self.text = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.pictures.append(dict(attrs)["alt"])

    def handle_data(self, data):
        self.text += data


def test_overview_has_every_figure_and_claim(reproduced):
    paper = reproduced[0] / "results/paper"
    page = Page((paper / "overview.html").read_text(encoding="utf-8"))
    assert page.pictures == [f"Fig. {n}" for n in FIGURES]
    claims = [claim for table in TABLES for claim in read_table(paper / f"{table}.csv")]
    assert page.text.lstrip().startswith("The paper, reproduced")
    assert f"{len(claims)} claims" in page.text
    for claim in claims:
        assert claim.claim in page.text
        assert claim.error in page.text
        # Those of growth and all that are drawn stand beside a figure too.
        seen = page.text.count(claim.claim)
        told = claim.verdict in ("no", "in part", "misprint")
        assert seen >= 1 + len(claim.figures.split()) + told
    assert page.text.count("Wall time: ") == PARTS
