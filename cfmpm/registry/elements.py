"""Background elements: the words of ``mesh.element``."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class ElementEntry:
    """Entry of an element.

    Attributes
    ----------
    description : str
        Number of material points per triangle, for the schema.
    place : str
        Place of its `cfmpm.elements.record.Element`.
    """

    description: str
    place: str


ELEMENTS: Registry[ElementEntry] = Registry(
    "element",
    {
        "T3": ElementEntry("1 point", "cfmpm.elements.t3:T3"),
        "T6": ElementEntry("3 points", "cfmpm.elements.t6:T6"),
        "T10": ElementEntry("6 points", "cfmpm.elements.t10:T10"),
        "T15": ElementEntry("12 points", "cfmpm.elements.t15:T15"),
    },
)
