"""Constitutive laws: what the word ``material.law`` of a scene stands for."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class Constant:
    """A constant of a law, besides E and nu: a key of the material.

    Attributes
    ----------
    name : str
    description : str
        With the unit.
    default : float or None
        None where the law needs a value.
    above, least, below, most : float or None
        What the value must be greater than, at least, less than, at most.
    """

    name: str
    description: str
    default: float | None = None
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None


@dataclass(frozen=True)
class Law:
    """A constitutive law at finite deformation; at small strain every one is that of Hooke.

    Attributes
    ----------
    description : str
        What the word is, going on from it: "is Hencky elasticity with a yield stress".
    code : str
        Place of the module of its kernels; `cfmpm.kernels.laws` says what is in it.
    constants : tuple of Constant
        Besides E and nu.
    plastic : bool
        Whether it flows, without change of volume, and keeps internal variables of that.
    elliptic : bool
        Whether it keeps its ellipticity at large stretches.
    """

    description: str
    code: str
    constants: tuple[Constant, ...] = ()
    plastic: bool = False
    elliptic: bool = False


_PLASTIC = (
    Constant("yield_stress", "of j2 [MPa]", above=0),
    Constant("hardening", "of j2: yield stress gained per plastic strain [MPa]", 0.0, least=0),
)
LAWS = Registry(
    "law",
    {
        "hencky": Law(
            "is the paper's, and loses ellipticity at stretches of 2 to 3",
            "cfmpm.kernels.laws.hencky",
        ),
        "ciarlet": Law(
            "is a neo-Hookean law that keeps it", "cfmpm.kernels.laws.ciarlet", elliptic=True
        ),
        "neo_hookean": Law("has lambda/2 (ln J)^2 instead", "cfmpm.kernels.laws.neo_hookean"),
        "j2": Law(
            "is Hencky elasticity with a yield stress",
            "cfmpm.kernels.laws.j2",
            _PLASTIC,
            plastic=True,
        ),
    },
)
