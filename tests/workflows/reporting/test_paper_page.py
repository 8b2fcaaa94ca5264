"""docs/paper.md is made from the statements, and what it refers to is there."""

from __future__ import annotations

import re

import pytest

from workflows.reporting.paper_page import TITLES, paper_page
from workflows.reporting.statements import FIGURE, statements

STATEMENTS = list(statements().values())


def test_the_page_is_up_to_date(root):
    page = (root / "docs/paper.md").read_text(encoding="utf-8")
    assert page == paper_page(), "python -m workflows.reporting.paper_page > docs/paper.md"


def test_every_statement_stands_once_on_the_page():
    page = paper_page()
    for one in STATEMENTS:
        assert page.count(f"| {one.paper} |") == 1
    assert f"Of {len(STATEMENTS)} statements" in page
    assert len(STATEMENTS) >= 85


@pytest.mark.parametrize("one", STATEMENTS, ids=lambda one: one.key)
def test_what_shows_a_statement_is_there(one, root):
    assert one.section.split(".")[0] in {title.split(".")[0] for title in TITLES}
    for place in one.shown:
        if place.startswith(FIGURE):
            assert 4 <= int(place.removeprefix(FIGURE)) <= 16
            continue
        path, _, test = place.partition("::")
        text = (root / path).read_text(encoding="utf-8")
        if test:
            assert re.search(rf"^def {test}\(", text, re.MULTILINE), place


def test_statements_shown_by_figures_are_decided_by_claims(root):
    """Their keys stand in the workflow's code, each once."""
    code = "".join(
        path.read_text(encoding="utf-8")
        for path in (root / "workflows").rglob("*.py")
        if path.name != "statements.py"
    )
    of_claims = [one for one in STATEMENTS if one.figures]
    there = {one.key for one in of_claims if f'"{one.key}"' in code}
    # Of a section of which no claim is decided yet none is missing.
    sections = {one.section for one in of_claims if one.key in there}
    missing = [one.key for one in of_claims if one.section in sections and one.key not in there]
    assert {"5.1", "6"} <= sections
    assert missing == []
