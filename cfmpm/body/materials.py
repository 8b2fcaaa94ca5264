"""Materials of the plane problem."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cfmpm.body.grid import Floats, Ints
from cfmpm.body.points import MaterialPoints
from cfmpm.body.volume_patches import Patches, patch_of
from cfmpm.elements.record import find_element
from cfmpm.kernels import finite
from cfmpm.kernels import laws as kernels
from cfmpm.scene.material import Material
from cfmpm.scene.model import Scene

# Poisson's ratio above which T3 in plane strain locks. J against T6 on one grid (single edge crack,
# size 20, tip 1 mm): 1.4 % low at 0.3, 2.4 % at 0.45, 7 % at 0.49, 28 % at 0.499.
LOCKING = 0.45

_LAWS = {
    "hencky": kernels.HENCKY,
    "neo_hookean": kernels.NEO_HOOKEAN,
    "ciarlet": kernels.CIARLET,
    "j2": kernels.J2,
}


@dataclass(frozen=True)
class Laws:
    """The materials of the regions at finite deformation.

    Attributes
    ----------
    law : (q,) int
        One of the constants of `kernels.laws`.
    parameters : (q, 4) float
        lambda, mu, yield stress and hardening modulus [MPa]; zero where a law has none.
    """

    law: Ints
    parameters: Floats

    def virgin_history(self, n_points: int) -> Floats:
        """Return the history of points that nothing has happened to."""
        plastic = bool((self.law == kernels.J2).any())
        return np.zeros((n_points, 6 if plastic else 0))


def material_laws(scene: Scene, region_names: tuple[str, ...]) -> Laws:
    """Return the materials of each region at finite deformation, in plane strain.

    Parameters
    ----------
    scene : Scene
        Expanded.
    region_names : tuple of str
        ``"body"`` first.
    """
    materials = region_materials(scene, region_names)
    yielding = [(material.yield_stress or 0.0, material.hardening) for material in materials]
    return Laws(
        law=np.array([_LAWS[material.law] for material in materials]),
        parameters=np.column_stack([lame_constants(scene, region_names), yielding]),
    )


def stress_across(laws: Laws, points: MaterialPoints, patches: Patches | None = None) -> Floats:
    """Return sigma_zz of finite deformation in plane strain.

    Parameters
    ----------
    laws : Laws
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
    law = laws.law[points.material]
    lam, mu = laws.parameters[points.material, :2].T
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


def region_materials(scene: Scene, region_names: tuple[str, ...]) -> list[Material]:
    """Return the material of each region: its own, or that of the body.

    Parameters
    ----------
    scene : Scene
        Expanded.
    region_names : tuple of str
        ``"body"`` first.

    Returns
    -------
    list of Material
    """
    source = scene.geometry or scene.mesh_file
    own = {region.name: region.material for region in source.regions} if source else {}
    return [own.get(name, scene.material) for name in region_names]


def lame_constants(scene: Scene, region_names: tuple[str, ...]) -> Floats:
    """Return Lame's constants of each region for the plane problem.

    Parameters
    ----------
    scene : Scene
        Expanded.
    region_names : tuple of str
        ``"body"`` first.

    Returns
    -------
    (q, 2) float
        lambda and mu [MPa]. In plane stress sigma_zz = 0 makes the strain eps_zz equal to
        -lambda (eps_xx + eps_yy) / (lambda + 2 mu); without it Hooke's law is that of plane
        strain with 2 lambda mu / (lambda + 2 mu) for lambda, which is returned.
    """
    rows = []
    for material in region_materials(scene, region_names):
        mu = material.E / (2.0 * (1.0 + material.nu))
        lam = material.E * material.nu / ((1.0 + material.nu) * (1.0 - 2.0 * material.nu))
        rows.append((2.0 * lam * mu / (lam + 2.0 * mu) if scene.plane == "stress" else lam, mu))
    return np.array(rows)


def locks(scene: Scene, region_names: tuple[str, ...]) -> bool:
    """Whether triangles lock: those that can, in plane strain near incompressibility.

    Plastic flow is isochoric whatever nu is.
    """
    tight = any(
        material.nu > LOCKING or material.law == "j2"
        for material in region_materials(scene, region_names)
    )
    return find_element(scene.mesh.element).locks and scene.plane == "strain" and tight


def plane_modulus(lam: float, mu: float) -> float:
    """Return E' of G = (K_I^2 + K_II^2) / E' [MPa]: E / (1 - nu^2), or E in plane stress."""
    return 4.0 * mu * (lam + mu) / (lam + 2.0 * mu)
