"""Constitutive laws: the words of ``material.law``."""

from __future__ import annotations

from dataclasses import dataclass

from cfmpm.registry.table import Registry


@dataclass(frozen=True)
class Constant:
    """A constant of a law in addition to E and nu; it is a key of the material.

    Attributes
    ----------
    name : str
        The key, and the name of the argument of the kernels.
    description : str
        Meaning and unit, for the schema.
    default : float or None
        None if the law needs a value.
    above, least, below, most : float or None
        Limits: value > above, value >= least, value < below, value <= most.
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
    """A constitutive law at finite deformation; at small strain every law is Hooke's law.

    Attributes
    ----------
    description : str
        Short description for the schema, such as "Hencky elasticity with a yield stress".
    code : str
        Name of the module of its kernels; `cfmpm.kernels.laws` describes its contents.
    constants : tuple of Constant
        Constants in addition to E and nu.
    plastic : bool
        Whether the law has plastic flow, which preserves volume, and its internal variables.
    elliptic : bool
        Whether the law is elliptic at all stretches.
    """

    description: str
    code: str
    constants: tuple[Constant, ...] = ()
    plastic: bool = False
    elliptic: bool = False


_PLASTIC = (
    Constant("yield_stress", "von Mises yield stress of j2 [MPa]", above=0),
    Constant(
        "hardening",
        "hardening modulus of j2: increase of yield stress per accumulated plastic strain [MPa]",
        0.0,
        least=0,
    ),
)
LAWS = Registry(
    "law",
    {
        "hencky": Law(
            "Hencky elasticity, as in the paper, which loses ellipticity at stretches of 2 to 3",
            "cfmpm.kernels.laws.hencky",
        ),
        "ciarlet": Law(
            "neo-Hookean with U = (J^2 - 1 - 2 ln J) / 4, elliptic at all stretches",
            "cfmpm.kernels.laws.ciarlet",
            elliptic=True,
        ),
        "neo_hookean": Law("neo-Hookean with U = (ln J)^2 / 2", "cfmpm.kernels.laws.neo_hookean"),
        "j2": Law(
            "Hencky elasticity with von Mises yield stress and linear isotropic hardening",
            "cfmpm.kernels.laws.j2",
            _PLASTIC,
            plastic=True,
        ),
    },
)
