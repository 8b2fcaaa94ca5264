"""Snakemake's report and the overview in a browser: nothing is blank, no error in the console."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from headless_chromium import Browser
from page_parts import write_moving, write_picture, write_time
from walk_through import walk_through_overview, walk_through_report

from workflows.reporting.claim_table import Claim, write_table
from workflows.reporting.html_page import html_image, html_page, write_text

TARGETS = ["reproduce-paper", "work-precision", "stability", "scaling"]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp("browser"))
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def made(checkout, snakemake, browser):
    """The repository with stand-ins for all results, but the real overview and report.

    Stand-ins are given to the rules as they are, so that sections, items and captions of the report
    are those of the workflow, and nothing is computed.
    """
    rows = snakemake(*TARGETS, "--summary", folder=checkout).stdout.splitlines()
    for row in rows[1:]:
        _stand_in(checkout / row.split("\t")[0])
    for table, claims in _claims().items():
        path = checkout / f"results/paper/{table}.csv"
        write_table(claims, table, path, path.with_suffix(".md"), path.with_suffix(".html"))
    only = ("overview", "--allowed-rules", "overview", "--force", "--cores", "1")
    # Measured times are no outputs: Snakemake says which are missing.
    plan = snakemake(*only, "--dry-run", folder=checkout, check=False)
    for time in re.findall(r"results/benchmarks/\S+\.tsv", plan.stdout + plan.stderr):
        write_time(checkout / time, 7.0)
    snakemake(*only, folder=checkout)
    snakemake(*TARGETS, "--touch", "--cores", "1", folder=checkout)
    snakemake(*TARGETS, "--report", "report.html", folder=checkout)
    return checkout


def _stand_in(path: Path) -> None:
    """Write a file of the kind that its name tells."""
    if path.name.startswith("film_") or path.suffix == ".gif":
        write_moving(path)
    elif path.suffix == ".png":
        write_picture(path)
    elif path.suffix == ".html":
        picture = path.with_suffix(".png")
        write_picture(picture, (2400, 1800))
        write_text(html_page(path.stem, html_image(picture, "a figure")), path)
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def _claims() -> dict[str, list[Claim]]:
    """Claims of each table."""

    def claim(text: str, held: str, figures: str) -> Claim:
        sentence = f"{text} is {held}."
        return Claim(text, "so", "so", "so", held, "a test", "", figures, sentence, key="a")

    return {
        "section_5_1": [claim("A norm", "yes", "5"), claim("A radius", "misprint", "6 7")],
        "large_strain": [
            claim("Fig. 8 a load", "no", "8"),
            claim("Fig. 8 a code", "not tested", "8"),
            Claim("5.1 a law", "", "so", "so", "yes", "a test"),
        ],
        "sections_5_2_to_5_5": [
            claim(f"5.{k} a path", "in part", str(2 * k + 5)) for k in range(2, 6)
        ],
    }


def test_every_result_of_the_report_is_shown(made, browser):
    found = walk_through_report(browser, made / "report.html")
    shown = [name for names in found.values() for name in names]
    assert {"Performance", "Stability"} < {*found}
    assert "What holds and what does not" in shown
    figures = [name for name in shown if name.startswith("Fig.")]
    assert [int(name[4:].split(":")[0]) for name in figures] == sorted(range(4, 17))
    assert len([name for name in shown if name.startswith("Film: ")]) == 4
    assert len(shown) == browser.value("Object.keys(results).length")


def test_the_overview_is_shown(made, browser):
    walk_through_overview(browser, made / "results/paper/overview.html")
