"""Plastic flow at finite deformation against closed forms."""

from __future__ import annotations

from dataclasses import replace

import large_strain_references as exact
import numpy as np
import posed
import pytest

from cfmpm.equilibrium import stepping
from cfmpm.scene.reading import scene_from_dict

E, NU = 210e3, 0.3
STEEL = {"E": E, "nu": NU, "law": "j2", "yield_stress": 200.0}


def block(material, element="T3"):
    outline = [[0, 0], [1, 0], [1, 1], [0, 1]]
    return scene_from_dict(
        {
            "name": "block",
            "geometry": {"outline": outline},
            "material": material,
            "kinematics": "finite",
            "loads": [{"edge": "edge_1", "displacement": {"x": 0, "y": 0}}],
            "mesh": {"element": element, "size": 0.4, "grading": "uniform"},
        }
    )


def driven(material, H, factors, element="T3"):
    """Points of a block whose boundary follows a displacement gradient, after each factor."""
    problem = posed.of_scene(block(material, element))
    nodes = rim(problem.grid.nodes)
    loading = posed.driven(problem.grid, nodes, problem.grid.nodes[nodes] @ H.T)
    problem = replace(problem, loading=loading)
    state = stepping.at_rest(problem)
    for factor in factors:
        state = stepping.advance(problem, state, factor)
        yield state.points


def rim(nodes):
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    return np.flatnonzero(((nodes == low) | (nodes == high)).any(axis=1))


@pytest.mark.parametrize("hardening", [0.0, 2000.0])
def test_simple_shear_of_j2(hardening):
    """Exact flow by an ordinary differential equation: 0.1 %."""
    shears = np.linspace(0.0, 0.5, 501)[1:]
    H = np.array([[0.0, 1.0], [0.0, 0.0]])
    material = {**STEEL, "hardening": hardening}
    stress = np.array([p.stress.mean(axis=0) for p in driven(material, H, shears)])
    xx, yy, xy = exact.sheared(E, NU, 200.0, hardening, shears)
    np.testing.assert_allclose(stress[:, 2], xy, rtol=1e-3)
    for found, known in ((stress[:, 0], xx), (stress[:, 1], yy)):
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-3 * xy.max())


@pytest.mark.parametrize("hardening", [0.0, 2000.0])
@pytest.mark.parametrize("stretch", [1.3, 0.75])
def test_confined_stretch_of_j2(stretch, hardening):
    """The logarithmic strain keeps its direction: exact in any number of steps."""
    H = np.array([[0.0, 0.0], [0.0, stretch - 1.0]])
    material = {**STEEL, "hardening": hardening}
    *_, points = driven(material, H, [0.5, 1.0])
    along, across = exact.confined_plastic(E, NU, 200.0, hardening, stretch)
    # Cauchy stress: J is the stretch.
    measured = points.stress.mean(axis=0) * stretch
    np.testing.assert_allclose(measured, [across, along, 0.0], rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(("element", "size"), [("T3", 0.5), ("T6", 2.0)])
def test_limit_pressure_of_a_thick_cylinder(element, size):
    """A quarter model whose bore is expanded by 1 %: fully plastic; 1 %."""
    inner, outer = 10.0, 20.0
    middle = np.sqrt(0.5)
    scene = scene_from_dict(
        {
            "name": "cylinder",
            "geometry": {
                "outline": [
                    {"at": [inner, 0], "edge": "bottom"},
                    {
                        "at": [outer, 0],
                        "edge": "outside",
                        "through": [outer * middle, outer * middle],
                    },
                    {"at": [0, outer], "edge": "left"},
                    {
                        "at": [0, inner],
                        "edge": "inside",
                        "through": [inner * middle, inner * middle],
                    },
                ]
            },
            "material": STEEL,
            "kinematics": "finite",
            "loads": [
                {"edge": "bottom", "displacement": {"y": 0}},
                {"edge": "left", "displacement": {"x": 0}},
            ],
            "mesh": {"element": element, "size": size, "grading": "uniform"},
        }
    )
    problem = posed.of_scene(scene)
    grid, loading = problem.grid, problem.loading
    wall = np.unique(grid.edges["inside"])
    outwards = grid.nodes[wall] / np.hypot(*grid.nodes[wall].T)[:, None]
    loads = loading.proportional
    held, values = loading.prescribed.copy(), loads.displacement.copy()
    held[wall], values[wall] = True, 0.01 * inner * outwards
    loads = replace(loads, displacement=values)
    problem = replace(problem, loading=replace(loading, prescribed=held, proportional=loads))
    state = stepping.at_rest(problem)
    for factor in np.linspace(0.0, 1.0, 21)[1:]:
        state = stepping.advance(problem, state, factor)
    a = 1.01 * inner
    b = np.sqrt(outer**2 - inner**2 + a**2)
    pressure = (state.internal_force[wall] * outwards).sum() / (0.5 * np.pi * a)
    limit = exact.cylinder_limit_pressure(a, b, 200.0)
    assert pressure == pytest.approx(limit, rel=0.01)
