"""What the paper states, sentence by sentence: one table for the claims and for docs/paper.md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

from ruamel.yaml import YAML

FOLDER = Path(__file__).parents[1] / "statements"
# Whether a statement held: these words alone.
HELD = ("yes", "in part", "no", "misprint", "not tested")
# Of an entry of `Statement.shown` that names a figure.
FIGURE = "Fig. "


@dataclass(frozen=True)
class Statement:
    """A statement of the paper that can be checked.

    Attributes
    ----------
    key : str
    section : str
        As 5.2.
    page : int
        Counted from the first of the article.
    claim : str
        What is checked, in a few words.
    paper : str
        What the paper states, in other words than its own, and nothing that it does not state.
    shown : tuple of str
        Where it is shown: figures, as Fig. 5, and tests, as tests/test_a.py::test_b.
    held : str
        One of `HELD`. Of a claim of the workflow the datasets decide; a test compares.
    note : str
        Why it is not tested, or what is right.
    """

    key: str
    section: str
    page: int
    claim: str
    paper: str
    shown: tuple[str, ...]
    held: str
    note: str = ""

    @property
    def figures(self) -> str:
        """The numbers of the figures that show it, separated by blanks."""
        found = (one.removeprefix(FIGURE) for one in self.shown if one.startswith(FIGURE))
        return " ".join(found)


@cache
def statements() -> Mapping[str, Statement]:
    """Read all statements, by their keys, in the order of the paper.

    Raises
    ------
    ValueError
        Where two have one key, or the verdict of one is no word of `HELD`.
    """
    found: dict[str, Statement] = {}
    for path in sorted(FOLDER.glob("*.yaml")):
        for key, values in YAML(typ="safe").load(path).items():
            if key in found:
                raise ValueError(f"{path.name}: two statements have the key {key}")
            one = Statement(key=key, **{**values, "shown": tuple(values["shown"])})
            if one.held not in HELD:
                raise ValueError(f"{path.name}: {key}: {one.held!r} is none of {', '.join(HELD)}")
            if one.held == "not tested" and not one.note:
                raise ValueError(f"{path.name}: {key}: not tested, and the note does not say why")
            found[key] = one
    return MappingProxyType(found)
