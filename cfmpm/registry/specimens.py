"""Families of specimens: the words of ``family.kind``."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class SpecimenEntry:
    """Entry of a family of specimens.

    Attributes
    ----------
    place : str
        Place of its model, a `cfmpm.scene.specimens.specimen.Specimen` whose ``kind`` is the word.
    """

    place: str


_HERE = "cfmpm.scene.specimens"
# Other packages: entry points of the group cfmpm.specimens.
SPECIMENS = Registry(
    "specimen",
    {
        "single_edge": SpecimenEntry(f"{_HERE}.single_edge:SingleEdge"),
        "centre_crack": SpecimenEntry(f"{_HERE}.centre_crack:CentreCrack"),
        "compact_tension": SpecimenEntry(f"{_HERE}.compact_tension:CompactTension"),
        "three_point_bend": SpecimenEntry(f"{_HERE}.three_point_bend:ThreePointBend"),
        "plate_with_holes": SpecimenEntry(f"{_HERE}.plate_with_holes:PlateWithHoles"),
    },
)
