"""docs/paper.md: what the paper states, where it is shown, and whether it holds.

``python -m workflows.reporting.paper_page > docs/paper.md``
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence

from workflows.reporting.statements import FIGURE, Statement, statements

TITLES = {
    "2": "Material point method",
    "3": "Configurational force",
    "4": "Crack growth and algorithm",
    "5.1": "Stationary edge crack",
    "5.2": "Growth in tension",
    "5.3": "Growth under shear",
    "5.4": "Two cracks and two holes",
    "5.5": "Beam with three holes",
    "6": "Conclusions",
}
WORDS = {
    "yes": "holds",
    "in part": "holds in part",
    "no": "does not hold",
    "misprint": "misprint",
    "not tested": "not tested",
}
HEAD = """# The paper, statement by statement

What sections 2 to 6 of Zhou, Coombs, Xu, Zhang and Wang, "A configurational force-based material
point method for crack propagation modelling in 2D", Theor. Appl. Fract. Mech. 117 (2022) 103186,
state that can be checked: in other words than the paper's, with the page counted from the first of
the article, where it is shown, and whether it holds.

{counts}

Figures are made by `snakemake reproduce-paper`, by the paper's own method
(`configs/paper/as_printed.yaml`) beside the best that can be had (`configs/paper/best.yaml`).
Statements shown by figures are decided from the computed datasets; `results/paper/overview.html`
has each with what was found, and a test compares its verdicts with those below. All others are
decided by the tests that are named. Misprints, and what is right, are listed in
[theory.md](theory.md#misprints-of-the-paper).

This page is made from `workflows/statements/` by
`python -m workflows.reporting.paper_page > docs/paper.md`.
"""


def paper_page() -> str:
    """Return the page as Markdown."""
    every = list(statements().values())
    found = Counter(one.held for one in every)
    counts = ", ".join(f"{found[held]} {_several(held)}" for held in WORDS)
    parts = [HEAD.format(counts=f"Of {len(every)} statements {counts}.")]
    for section, title in TITLES.items():
        own = [one for one in every if _within(one.section, section)]
        parts.append(f"\n## {section} {title}\n\n{_table(own)}")
    return "".join(parts)


def _several(held: str) -> str:
    return {
        "yes": "hold",
        "in part": "hold in part",
        "no": "do not hold",
        "misprint": "are misprints",
        "not tested": "are not tested",
    }[held]


def _within(section: str, of: str) -> bool:
    return section == of or section.startswith(f"{of}.")


def _table(rows: Sequence[Statement]) -> str:
    """A table of one section, in the order of the pages."""
    head = "| page | the paper states | verdict | shown by |\n|---|---|---|---|\n"
    return head + "".join(
        f"| {one.page} | {one.paper} | {_verdict(one)} | {', '.join(map(_shown, one.shown))} |\n"
        for one in sorted(rows, key=lambda one: one.page)
    )


def _verdict(one: Statement) -> str:
    return f"{WORDS[one.held]}{f': {one.note}' if one.note else ''}"


def _shown(place: str) -> str:
    """A figure, or a link to a test or file."""
    if place.startswith(FIGURE):
        return place
    path, _, test = place.partition("::")
    if path == "docs/paper.md":
        return "this page"
    return f"[{(test or path.rsplit('/', 1)[-1]).replace('_', chr(92) + '_')}](../{path})"


if __name__ == "__main__":
    sys.stdout.write(paper_page())
