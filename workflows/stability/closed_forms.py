"""Closed forms for growing cracks, along the lengths that they have reached.

Each takes the scene and the paths of length [mm] and load factor, and gives the known path.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from cfmpm.scene import Scene, expand

Floats = NDArray[np.float64]
# Points of the trapezoidal rule for the number of cycles between two lengths.
FINE = 200


def edge_crack_rate(scene: Scene, length: Floats, load_factor: Floats) -> Floats:
    """G of an edge crack in a strip in tension, ends free to turn [N/mm]; K to 0.5 %.

    Tada, Paris and Irwin (2000), 2.11; a strip three times as long as wide or longer.
    """
    return (load_factor * _edge_crack_factor(scene, length)) ** 2 / _modulus(scene)


def edge_crack_cycles(scene: Scene, length: Floats, load_factor: Floats) -> Floats:
    """Cycles of Paris' law with that K, from the first length on."""
    assert scene.fatigue is not None
    fine = np.linspace(length[:-1], length[1:], FINE)
    span = (1.0 - scene.fatigue.load_ratio) * _edge_crack_factor(scene, fine)
    spent = np.trapezoid(1.0 / (scene.fatigue.C * span**scene.fatigue.m), fine, axis=0)
    return np.append(0.0, np.cumsum(spent))


def double_cantilever_rate(scene: Scene, length: Floats, load_factor: Floats) -> Floats:
    """G of a double cantilever beam of half height h with opening d at its end [N/mm].

    K = 3^0.5 E' d h^1.5 / (4 (a + 0.6728 h)^2) from K and opening of the corrected beam (Fichter
    1983); for arms longer than twice their height, and as much ahead of the crack.
    """
    h = 0.5 * _extent(scene)[1]
    arms = [load.displacement for load in scene.loads if load.name in ("top", "bottom")]
    d = sum(abs(arm.y or 0.0) for arm in arms if arm is not None)
    K = np.sqrt(3.0) * _modulus(scene) * d * h**1.5 / (4.0 * (length + 0.6728 * h) ** 2)
    return (load_factor * K) ** 2 / _modulus(scene)


CLOSED_FORMS: Mapping[str, tuple[str, Callable[[Scene, Floats, Floats], Floats]]] = {
    "edge_crack_rate": ("J_path", edge_crack_rate),
    "edge_crack_cycles": ("cycles", edge_crack_cycles),
    "double_cantilever_rate": ("J_path", double_cantilever_rate),
}


def _edge_crack_factor(scene: Scene, length: Floats) -> Floats:
    """K under the loads of the scene [MPa mm^0.5]."""
    width, _ = _extent(scene)
    (tension,) = (load.traction[1] for load in scene.loads if load.edge == "top" and load.traction)
    x = 0.5 * np.pi * length / width
    shape = 0.752 + 2.02 * length / width + 0.37 * (1.0 - np.sin(x)) ** 3
    spread = np.sqrt(np.pi * length) * np.sqrt(np.tan(x) / x)
    return np.asarray(tension * spread * shape / np.cos(x))


def _extent(scene: Scene) -> tuple[float, float]:
    """Width and height of the body [mm]."""
    geometry = expand(scene).geometry
    assert geometry is not None
    width, height = np.ptp([corner.at for corner in geometry.outline], axis=0)
    return float(width), float(height)


def _modulus(scene: Scene) -> float:
    """E' of plane strain [MPa]."""
    return scene.material.E / (1.0 - scene.material.nu**2)
