"""The background elements that ``mesh.element`` knows."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class ElementEntry:
    """An element by its word.

    Attributes
    ----------
    description : str
        How many material points a triangle has, for the schema.
    place : str
        Of its `cfmpm.elements.record.Element`.
    """

    description: str
    place: str


ELEMENTS: Registry[ElementEntry] = Registry(
    "element",
    {
        "T3": ElementEntry("1 point", "cfmpm.elements.t3:T3"),
        "T6": ElementEntry("3 points", "cfmpm.elements.t6:T6"),
    },
)
