"""K at finite deformation: exact under rotation, missing where strain is not small."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cfmpm import mechanics
from cfmpm.build import build
from cfmpm.clock import Clock
from cfmpm.fracture import cf
from cfmpm.fracture.corotation import corotated_factors
from cfmpm.fracture.interaction import intensity_factors
from cfmpm.scene import expand, scene_from_dict
from cfmpm.simulation import run


def pulled(traction: float, **keys: Any) -> dict[str, Any]:
    return {
        "name": "pulled",
        "family": {
            "kind": "single_edge",
            "width": 10,
            "height": 40,
            "crack_length": 3,
            "traction": traction,
        },
        "material": {"E": 210e3, "nu": 0.3},
        "mesh": {"element": "T6", "size": 2},
        **keys,
    }


@pytest.mark.parametrize("angle", [0.0, 20.0, 90.0, -170.0])
def test_a_rotation_changes_nothing(angle: float) -> None:
    """A rigid rotation of a state of small strain does not change K."""
    scene = scene_from_dict(pulled(1.0, kinematics="small"))
    body, gradients = mechanics.locate(build(scene))
    balance = mechanics.solve(expand(scene), body, gradients, None, 1.0, Clock(lambda phase: None))
    (tip,), (domain,) = body.grid.tips, body.tip_domains
    q = cf.ring_weight(body.grid, tip, max(domain.radii))
    material, points, none = body.materials.row(0), balance.points, np.zeros(2)
    straight = intensity_factors(body.grid, points, gradients, material, tip, q, none)

    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    R = np.array([[c, -s], [s, c]])
    sigma = R @ points.stress[:, [[0, 2], [2, 1]]] @ R.T
    turned = replace(
        points,
        displacement_gradient=R @ (np.eye(2) + points.displacement_gradient) - np.eye(2),
        stress=sigma.reshape(-1, 4)[:, [0, 3, 1]].copy(),
    )
    found = corotated_factors(body.grid, turned, gradients, material, tip, q, none, straight.G)
    assert found is not None
    scale = abs(straight.K_I)
    # The mean rotation of the ring itself, of the size of the strain, is taken out besides.
    tolerance = 5.0 * np.abs(points.displacement_gradient).max()
    assert abs(found.K_I - straight.K_I) <= tolerance * scale
    assert abs(found.K_II - straight.K_II) <= tolerance * scale
    assert abs(found.T_stress / straight.T_stress - 1.0) <= 20 * tolerance


def test_factors_go_over_into_those_of_small_strain() -> None:
    """The difference to small strain is proportional to the load."""
    off = []
    for traction in (1.0, 10.0):
        small, finite = (
            run(scene_from_dict(pulled(traction, kinematics=k))).history
            for k in ("small", "finite")
        )
        off.append(abs(finite.K_I.item() / small.K_I.item() - 1.0))
        # G is J at finite deformation, and the factors give it.
        modulus = 210e3 / (1.0 - 0.3**2)
        assert finite.K_I.item() ** 2 / modulus == pytest.approx(finite.J.item(), rel=5e-3)
        assert finite.G.item() == finite.J.item()
        assert np.isfinite(finite.T_stress.item())
        assert np.isfinite(finite.G_kink.item())
    assert off[0] < 2e-4
    assert off[1] == pytest.approx(10.0 * off[0], rel=0.1)


def test_no_factors_where_strain_is_not_small() -> None:
    keys = {
        "kinematics": "finite",
        "load_steps": 4,
        "mesh": {"element": "T6", "size": 2, "grading": {"tip_size": 0.1}},
        "fracture": {"radii": [0.3, 0.8]},
    }
    history = run(scene_from_dict(pulled(20e3) | keys)).history
    assert np.isfinite(history.J.values).all()
    assert np.isnan(history.K_I.values).any()
    assert np.isfinite(history.K_I.values).any()
    known = np.isfinite(history.K_I_radius.values)
    assert (known.all(axis=-1) == known.any(axis=-1)).all()  # of all radii or none
