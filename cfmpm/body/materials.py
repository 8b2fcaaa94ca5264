"""The materials of a body: one table, a row for each region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints
from cfmpm.body.points import DeformedPoints
from cfmpm.body.volume_patches import Patches, patch_of
from cfmpm.kernels import finite
from cfmpm.kernels.laws import dispatch
from cfmpm.registry.laws import LAWS, Law

# Poisson's ratio above which T3 in plane strain locks. J against T6 on one grid (single edge crack,
# size 20, tip 1 mm): 1.4 % low at 0.3, 2.4 % at 0.45, 7 % at 0.49, 28 % at 0.499.
LOCKING = 0.45
# Name of the internal variable of plastic work.
PLASTIC_WORK = "plastic_work"


@dataclass(frozen=True)
class Materials:
    """Table of the materials of the regions, in the order of their names.

    Attributes
    ----------
    elastic : (q, 3, 3) float
        Elastic matrix of the plane problem [MPa]: sigma xx, yy, xy from strain xx, yy, 2 xy.
    volumetric : (q,) float
        The part that patches share: lambda, the normal stress per volume change [MPa].
    unshared : (q, 3, 3) float
        The elastic matrix without that part.
    across : (q, 3) float
        Coefficients of sigma_zz at small strain in terms of sigma xx, yy, xy.
    lame : (q, 2) float
        Lame's constants lambda and mu of the plane problem [MPa], for the auxiliary fields at crack
        tips, which are those of an isotropic material.
    E : (q,) float
        Young's modulus [MPa].
    g_c : (q,) float
        Critical energy release rate [N/mm]; nan if none is given.
    law : (q,) int
        Number of the law in `laws.dispatch.NUMBERS`.
    constants : (q, c) float
        Constants of the laws: lambda, mu [MPa], further constants from the third column on.
    plastic : (q,) bool
        Whether the law has plastic flow.
    n_variables : (q,) int
        Number of internal variables of the law for each point.
    work : (q,) int
        Index of the internal variable of plastic work; -1 if there is none.
    locks : (q,) bool
        Whether elements with `Element.locks` lock: in plane strain near incompressibility or with
        plastic flow, which is isochoric for any Poisson's ratio.
    """

    elastic: Floats
    volumetric: Floats
    unshared: Floats
    across: Floats
    lame: Floats
    E: Floats
    g_c: Floats
    law: Ints
    constants: Floats
    plastic: NDArray[np.bool_]
    n_variables: Ints
    work: Ints
    locks: NDArray[np.bool_]

    def row(self, region: int) -> Self:
        """Return the table of one region alone."""
        rows = slice(region, region + 1)
        return type(self)(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @property
    def n_internal(self) -> int:
        """Number of internal variables of a point."""
        return int(self.n_variables.max())

    def plastic_work(self, points: DeformedPoints) -> Floats:
        """Return the plastic work of points per reference volume [MPa], (p,)."""
        column = self.work[points.material]
        kept = points.internal_variables
        return np.where(column < 0, 0.0, kept[np.arange(len(kept)), column])


def material_table(rows: Sequence[Mapping[str, Any]], plane: str) -> Materials:
    """Make the table of the materials of a body.

    Parameters
    ----------
    rows : sequence of mapping of str to value
        Constants of each region by their keys in a scene: `E` [MPa] and `nu`; optionally `g_c`,
        `law` and the constants of the law.
    plane : {"strain", "stress"}

    Returns
    -------
    Materials

    Notes
    -----
    In plane stress sigma_zz = 0 makes the strain eps_zz equal to
    -lambda (eps_xx + eps_yy) / (lambda + 2 mu); without it Hooke's law is that of plane strain with
    2 lambda mu / (lambda + 2 mu) for lambda.
    """
    E = np.array([row["E"] for row in rows], float)
    nu = np.array([row["nu"] for row in rows], float)
    words = [row.get("law", "hencky") for row in rows]
    mu = E / (2.0 * (1.0 + nu))
    lam = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    if plane == "stress":
        lam = 2.0 * lam * mu / (lam + 2.0 * mu)
    unshared = mu[:, None, None] * np.diag([2.0, 2.0, 1.0])
    elastic = unshared.copy()
    elastic[:, :2, :2] += lam[:, None, None]
    across = np.zeros((len(rows), 3))
    if plane == "strain":
        across[:, :2] = nu[:, None]
    laws = [LAWS[word] for word in words]
    plastic = np.array([law.plastic for law in laws])
    kept = [dispatch.INTERNAL_VARIABLES[word] for word in words]
    own = [_own_constants(law, row) for law, row in zip(laws, rows, strict=True)]
    return Materials(
        elastic=elastic,
        volumetric=lam,
        unshared=unshared,
        across=across,
        lame=np.column_stack([lam, mu]),
        E=E,
        g_c=np.array([row.get("g_c") for row in rows], float),
        law=np.array([dispatch.NUMBERS[word] for word in words]),
        constants=np.column_stack([lam, mu, own]),
        plastic=plastic,
        n_variables=np.array([len(names) for names in kept]),
        work=np.array(
            [names.index(PLASTIC_WORK) if PLASTIC_WORK in names else -1 for names in kept]
        ),
        locks=((nu > LOCKING) | plastic) & (plane == "strain"),
    )


def stress_across(
    materials: Materials, points: DeformedPoints, patches: Patches | None = None
) -> Floats:
    """Return sigma_zz of finite deformation in plane strain.

    Parameters
    ----------
    materials : Materials
    points : DeformedPoints
    patches : Patches, optional
        Patches over which the volume ratio was averaged.

    Returns
    -------
    (p,) float
        Cauchy stress [MPa].
    """
    result: Floats = finite.stresses_across(
        points.volume,
        points.material,
        materials.law,
        materials.constants,
        points.displacement_gradient,
        points.stress,
        patch_of(patches, points),
    )
    return result


def departures_at_rest(materials: Materials) -> Floats:
    """Return the relative difference of each law's stiffness at zero strain from Hooke's, (q,).

    The largest difference of the entries of the spatial tangent in plane strain, over the largest
    entry of the elastic matrix.
    """
    virgin = np.zeros((1, materials.n_internal))
    departures = []
    for m, law in enumerate(materials.law):
        no_strain = (0.0, 0.0, 0.0, 0.0)
        c = dispatch.respond(law, materials.constants, m, no_strain, 0.0, False, virgin, 0)[2]
        tangent = np.array([[c[0], c[2], c[3]], [c[2], c[1], c[4]], [c[3], c[4], c[5]]])
        hooke = materials.elastic[m]
        departures.append(np.abs(tangent - hooke).max() / np.abs(hooke).max())
    return np.array(departures)


def _own_constants(law: Law, row: Mapping[str, Any]) -> list[float]:
    """Constants of a law besides E and nu, padded to the largest number of any law."""
    values = [row.get(constant.name, constant.default) for constant in law.constants]
    return values + [0.0] * (dispatch.N_CONSTANTS - 2 - len(values))


def plane_modulus(lam: float, mu: float) -> float:
    """Return E' of G = (K_I^2 + K_II^2) / E' [MPa]: E / (1 - nu^2), or E in plane stress.

    Examples
    --------
    >>> E, nu = 210e3, 0.3
    >>> lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    >>> round(plane_modulus(lam, mu) / (E / (1 - nu**2)), 12)
    1.0
    """
    return 4.0 * mu * (lam + mu) / (lam + 2.0 * mu)
