"""Claims of the paper and what is beyond it: the tables, and the statements behind them."""

from __future__ import annotations

import pytest

from workflows.reporting import statements as of_paper
from workflows.reporting.claim_table import Claim, not_tested, paper_claim, read_table, write_table
from workflows.reporting.statements import HELD, statements

FOUND = paper_claim(
    "tip_oscillates", found="it does", held="in part", test="a test", sentence="It oscillates."
)
EXTRA = Claim("5.1 Another law", "", "1.0", "1.1", "no", "a test", error="10 %")


def test_a_claim_has_what_the_paper_states_from_the_statements():
    one = statements()["tip_oscillates"]
    assert (FOUND.section, FOUND.page, FOUND.figures) == ("5.1", "8", "5")
    assert FOUND.paper == one.paper
    assert FOUND.stated == f"{one.paper} (section 5.1, page 8)"
    assert EXTRA.stated == ""
    with pytest.raises(KeyError):
        paper_claim("nowhere", found="", held="yes", test="", sentence="")


def test_what_is_not_tested_says_why():
    one = not_tested("holes_phase_field")
    assert one.verdict == "not tested"
    assert one.sentence == one.test == statements()["holes_phase_field"].note


def test_tables(tmp_path):
    out = [tmp_path / f"claims.{kind}" for kind in ("csv", "md", "html")]
    write_table([EXTRA, FOUND], "Title", *out)
    assert read_table(out[0]) == [EXTRA, FOUND]
    for path in out[1:]:
        text = path.read_text(encoding="utf-8")
        # Claims of the paper first, and apart.
        assert text.index("Claims of the paper") < text.index(FOUND.claim)
        assert text.index(FOUND.claim) < text.index("Beyond the paper") < text.index(EXTRA.claim)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("b: {section: a, page: 1, claim: c, paper: p, shown: [], held: maybe}", "'maybe' is none"),
        ("b: {section: a, page: 1, claim: c, paper: p, shown: [], held: not tested}", "say why"),
    ],
)
def test_a_statement_that_breaks_a_rule_is_refused(text, said, tmp_path, monkeypatch):
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(of_paper, "FOLDER", tmp_path)
    of_paper.statements.cache_clear()
    try:
        with pytest.raises(ValueError, match=said):
            of_paper.statements()
    finally:
        monkeypatch.undo()
        of_paper.statements.cache_clear()


def test_every_statement_is_whole():
    for one in statements().values():
        assert one.paper.endswith(".")
        assert one.shown
        assert one.held in HELD
        assert 2 <= one.page <= 14
