"""Kinds of loads and supports: each is a key of a load of a scene."""

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
        Of its key, with the unit.
    value : str
        Place of the type of what the key holds, as pydantic takes it.
    code : str
        Place of the function (value, place, grid) that makes it nodal values, an `Applied`.
    places : tuple of str
        Where it may act; empty for the whole body.
    unit : str
        Of the components, for pictures.
    holds : bool
        Whether it prescribes a displacement, which only the nodes inside a box get.
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
            "on an edge, a box or a point [mm]",
            "cfmpm.scene.components:Components",
            "cfmpm.body.load_kinds.displacement:apply",
            (EDGE, BOX, POINT),
            "mm",
            holds=True,
        ),
        "traction": LoadKind(
            "on an edge or a box [MPa]",
            _VECTOR,
            "cfmpm.body.load_kinds.traction:apply",
            (EDGE, BOX),
            "MPa",
        ),
        "force": LoadKind(
            "on a point, per thickness [N/mm]",
            _VECTOR,
            "cfmpm.body.load_kinds.force:apply",
            (POINT,),
            "N/mm",
        ),
        "body_force": LoadKind(
            "in the whole body [N/mm^3]",
            _VECTOR,
            "cfmpm.body.load_kinds.body_force:apply",
            unit="N/mm³",
        ),
    },
)
