"""The materials of a body: one table, a row for each region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import Floats, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.body.volume_patches import Patches, patch_of
from cfmpm.kernels import finite
from cfmpm.kernels import laws as kernels

# Poisson's ratio above which T3 in plane strain locks. J against T6 on one grid (single edge crack,
# size 20, tip 1 mm): 1.4 % low at 0.3, 2.4 % at 0.45, 7 % at 0.49, 28 % at 0.499.
LOCKING = 0.45
# Column of the history of points.
PLASTIC_WORK = 5

_LAWS = {
    "hencky": kernels.HENCKY,
    "neo_hookean": kernels.NEO_HOOKEAN,
    "ciarlet": kernels.CIARLET,
    "j2": kernels.J2,
}


@dataclass(frozen=True)
class Materials:
    """The materials of the regions, in the order of their names.

    Attributes
    ----------
    elastic : (q, 3, 3) float
        Elastic matrix of the plane problem [MPa]: sigma xx, yy, xy from strain xx, yy, 2 xy.
    across : (q, 3) float
        What sigma_zz of small strain is of sigma xx, yy, xy.
    lame : (q, 2) float
        Lame's constants lambda and mu of the plane problem [MPa], where isotropy is needed: the
        auxiliary fields at crack tips, the shared change of volume, the laws of finite deformation.
    E : (q,) float
        Young's modulus [MPa].
    g_c : (q,) float
        Critical energy release rate [N/mm]; nan where there is none.
    law : (q,) int
        One of the constants of `kernels.laws`.
    constants : (q, c) float
        What the laws read: lambda, mu, yield stress and hardening modulus [MPa]; zero where a law
        has none.
    plastic : (q,) bool
        Whether the law has a history.
    locks : (q,) bool
        Whether elements lock that can (`Element.locks`): plane strain near incompressibility.
        Plastic flow is isochoric whatever Poisson's ratio is.
    """

    elastic: Floats
    across: Floats
    lame: Floats
    E: Floats
    g_c: Floats
    law: Ints
    constants: Floats
    plastic: NDArray[np.bool_]
    locks: NDArray[np.bool_]

    def row(self, region: int) -> Self:
        """Return the table of one region alone."""
        rows = slice(region, region + 1)
        return type(self)(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    def virgin_history(self, n_points: int) -> Floats:
        """Return the history of points that nothing has happened to."""
        return np.zeros((n_points, 6 if self.plastic.any() else 0))


def material_table(rows: Sequence[Mapping[str, Any]], plane: str) -> Materials:
    """Make the table of the materials of a body.

    Parameters
    ----------
    rows : sequence of mapping of str to value
        Constants of each region by their keys in a scene: `E` [MPa] and `nu`; `g_c`, `law` and the
        constants of that where they are not those of the defaults.
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
    elastic = np.zeros((len(rows), 3, 3))
    elastic[:, [0, 1], [0, 1]] = (lam + 2.0 * mu)[:, None]
    elastic[:, [0, 1], [1, 0]] = lam[:, None]
    elastic[:, 2, 2] = mu
    across = np.zeros((len(rows), 3))
    if plane == "strain":
        across[:, :2] = nu[:, None]
    law = np.array([_LAWS[word] for word in words])
    plastic = law == kernels.J2
    yielding = [(row.get("yield_stress") or 0.0, row.get("hardening", 0.0)) for row in rows]
    return Materials(
        elastic=elastic,
        across=across,
        lame=np.column_stack([lam, mu]),
        E=E,
        g_c=np.array([row.get("g_c") for row in rows], float),
        law=law,
        constants=np.column_stack([lam, mu, yielding]),
        plastic=plastic,
        locks=((nu > LOCKING) | plastic) & (plane == "strain"),
    )


def stress_across(
    materials: Materials, points: MaterialPoints, patches: Patches | None = None
) -> Floats:
    """Return sigma_zz of finite deformation in plane strain.

    Parameters
    ----------
    materials : Materials
    points : MaterialPoints
    patches : Patches, optional
        Over which the volume ratio of their pressure was averaged.

    Returns
    -------
    (p,) float
        Cauchy stress [MPa]. It is lambda U'(J) where nothing else strains or flows across, with J
        the mean over the patch; the logarithmic laws have tr tau = 3 lambda J U' + 2 mu ln J,
        however plastic flow shares it out.
    """
    law = materials.law[points.material]
    lam, mu = materials.lame[points.material].T
    H = points.displacement_gradient
    y = H[:, 0, 0] + H[:, 1, 1] + (H[:, 0, 0] * H[:, 1, 1] - H[:, 0, 1] * H[:, 1, 0])
    mean = y
    if patches is not None:
        patch = patch_of(patches, points)
        mean = finite.patch_means(points.volume, H, patch)[patch]
    J, log_J = 1.0 + mean, np.log1p(mean)
    pressure = np.where(
        law == kernels.CIARLET, 0.5 * lam * mean * (2.0 + mean) / J, lam * log_J / J
    )
    trace = 3.0 * pressure + 2.0 * mu * np.log1p(y) / (1.0 + y)
    logarithmic = np.isin(law, [kernels.HENCKY, kernels.J2])
    return np.where(logarithmic, trace - points.stress[:, 0] - points.stress[:, 1], pressure)


def plane_modulus(lam: float, mu: float) -> float:
    """Return E' of G = (K_I^2 + K_II^2) / E' [MPa]: E / (1 - nu^2), or E in plane stress."""
    return 4.0 * mu * (lam + mu) / (lam + 2.0 * mu)
