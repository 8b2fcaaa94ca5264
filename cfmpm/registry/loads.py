"""Kinds of loads and supports: each is a key of the loads of a scene."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry

EDGE, BOX, POINT = "edge", "box", "point"


@dataclass(frozen=True)
class LoadKind:
    """A kind of load or support.

    Attributes
    ----------
    description : str
        Description of the key for the schema, with the unit.
    value : str
        Place of the type of the value, an annotation for pydantic.
    code : str
        Place of the function (value, place, grid) that returns its nodal values,
        `body.applied.Applied`.
    places : tuple of str
        Keys of the places where it may act; empty if it acts on the whole body.
    unit : str
        Unit of the components, for figures.
    holds : bool
        Whether it prescribes a displacement; in a box it then acts on the nodes inside only.
    """

    description: str
    value: str
    code: str
    places: tuple[str, ...] = ()
    unit: str = ""
    holds: bool = False


_VECTOR = "cfmpm.scene.quantities:Vector"
LOADS = Registry(
    "load",
    {
        "displacement": LoadKind(
            "displacement of an edge, a box or a point [mm]",
            "cfmpm.scene.components:Components",
            "cfmpm.body.load_kinds.displacement:apply",
            (EDGE, BOX, POINT),
            "mm",
            holds=True,
        ),
        "traction": LoadKind(
            "traction on an edge or a box [MPa]",
            _VECTOR,
            "cfmpm.body.load_kinds.traction:apply",
            (EDGE, BOX),
            "MPa",
        ),
        "force": LoadKind(
            "force on a point, per mm of thickness [N/mm]",
            _VECTOR,
            "cfmpm.body.load_kinds.force:apply",
            (POINT,),
            "N/mm",
        ),
        "body_force": LoadKind(
            "body force in the whole body [N/mm^3]",
            _VECTOR,
            "cfmpm.body.load_kinds.body_force:apply",
            unit="N/mm³",
        ),
    },
)
