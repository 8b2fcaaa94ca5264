"""Materials of the plane problem."""

from __future__ import annotations

import numpy as np

from cfmpm.grid import Floats
from cfmpm.scene.model import Material, Scene


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


def plane_modulus(lam: float, mu: float) -> float:
    """Return E' of G = (K_I^2 + K_II^2) / E' [MPa]: E / (1 - nu^2), or E in plane stress."""
    return 4.0 * mu * (lam + mu) / (lam + 2.0 * mu)
