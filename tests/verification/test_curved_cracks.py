"""Curved cracks made of short segments: against the exact arc, from geometry and mesh files."""

from __future__ import annotations

from itertools import pairwise

import gmsh
import numpy as np
import pytest

from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run

R, SIDE, STRESS = 10.0, 400.0, 10.0  # mm, mm, MPa
PULL = [
    {"edge": name, "traction": [STRESS * x, STRESS * y]}
    for name, x, y in [("bottom", 0, -1), ("right", 1, 0), ("top", 0, 1), ("left", -1, 0)]
]


def arc(half_angle: float, count: int) -> np.ndarray:
    """Points of an arc about the y axis, (count + 1, 2) [mm]."""
    angles = np.radians(np.linspace(90 + half_angle, 90 - half_angle, count + 1))
    return R * np.column_stack([np.cos(angles), np.sin(angles) - 0.7])


def exact(half_angle: float) -> tuple[float, float]:
    """K_I and |K_II| of an arc in a sheet under equibiaxial tension.

    Cotterell and Rice (1980, Int. J. Fracture 16, 155-169), after Muskhelishvili.
    """
    a = np.radians(half_angle)
    common = STRESS * np.sqrt(np.pi * R * np.sin(a)) / (1 + np.sin(a / 2) ** 2)
    return common * np.cos(a / 2), common * np.sin(a / 2)


def scene(body: dict, **keys) -> dict:
    return {"name": "arc", "material": {"E": 210e3, "nu": 0.3}, "loads": PULL, **body, **keys}


def as_geometry(half_angle: float, count: int) -> dict:
    h = SIDE / 2
    corners = [("bottom", -h, -h), ("right", h, -h), ("top", h, h), ("left", -h, h)]
    return {
        "geometry": {
            "outline": [{"at": [x, y], "edge": name} for name, x, y in corners],
            "cracks": [{"name": "arc", "points": arc(half_angle, count).tolist()}],
        }
    }


def as_mesh_file(path, half_angle: float, size: float, version: float = 4.1) -> dict:
    """An arc meshed by gmsh, with its nodes on the arc."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    cad, h = gmsh.model.geo, SIDE / 2
    corners = [cad.addPoint(x, y, 0, 40) for x, y in [(-h, -h), (h, -h), (h, h), (-h, h)]]
    lines = [cad.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    start, end = (cad.addPoint(*arc(half_angle, 1)[i], 0, size) for i in (0, 1))
    centre = cad.addPoint(0, -0.7 * R, 0)
    crack = cad.addCircleArc(start, centre, end)
    cad.addPlaneSurface([cad.addCurveLoop(lines)])
    cad.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, 1)
    for name, curve in {
        **dict(zip(("bottom", "right", "top", "left"), lines, strict=True))
    }.items():
        gmsh.model.addPhysicalGroup(1, [curve], name=name)
    gmsh.model.addPhysicalGroup(1, [-crack], name="arc")
    gmsh.model.addPhysicalGroup(2, [1], name="plate")
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()
    return {"mesh_file": {"file": str(path), "cracks": ["arc"]}}


def assert_exact(history, half_angle: float, allowed: float) -> None:
    k_1, k_2 = exact(half_angle)
    modulus = 210e3 / (1 - 0.3**2)
    np.testing.assert_allclose(history.K_I, k_1, rtol=allowed)
    np.testing.assert_allclose(abs(history.K_II), k_2, atol=allowed * k_1)
    np.testing.assert_allclose(history.G, (k_1**2 + k_2**2) / modulus, rtol=2 * allowed)
    np.testing.assert_allclose(history.J, history.G, rtol=2 * allowed)
    if allowed < 0.02:  # linear triangles are told that they are coarse
        assert history.attrs["warnings"] == "[]"


@pytest.mark.parametrize("half_angle", [10, 30, 45])
def test_an_arc_of_many_points_has_the_factors_of_the_arc(half_angle):
    history = run(scene_from_dict(scene(as_geometry(half_angle, 240)))).history
    assert_exact(history, half_angle, 0.005)
    assert (history.domain_radius > 0.15 * 2 * R * np.sin(np.radians(half_angle))).all()


@pytest.mark.parametrize(("element", "allowed"), [("T3", 0.03), ("T6", 0.01)])
def test_the_arc_of_a_mesh_file(tmp_path, element, allowed):
    body = as_mesh_file(tmp_path / "a.msh", 30, 0.3 if element == "T6" else 0.1)
    history = run(scene_from_dict(scene(body, mesh={"element": element}))).history
    assert_exact(history, 30, allowed)


def test_rings_along_the_bends_agree(tmp_path):
    """Rings from six elements to half of the arc: K, G, J do not depend on bends and radii."""
    body = as_mesh_file(tmp_path / "a.msh", 45, 0.2)
    history = run(scene_from_dict(scene(body, fracture={"radii": [1.2, 2.0, 4.0, 7.0]}))).history
    np.testing.assert_array_equal(history.domain_radius[0], [[1.2, 2.0, 4.0, 7.0]] * 2)
    k_1, _ = exact(45)
    for name, scale in (("K_I", k_1), ("K_II", k_1), ("G", None), ("J", None)):
        values = history[f"{name}_radius"].values[0]
        spread = np.ptp(values, axis=1)
        # G and J are squares of K.
        assert (spread < (3e-3 * scale if scale else 6e-3 * values.max())).all(), name


def test_growth_and_finite_deformation_see_the_same_arc(tmp_path):
    """Equal results: stationary, first step of growth, finite deformation at a small load."""
    body = as_mesh_file(tmp_path / "a.msh", 30, 0.15)
    steel = {"material": {"E": 210e3, "nu": 0.3, "g_c": 1e9}}
    rest, growth, finite = (
        run(scene_from_dict(scene(body) | steel | keys)).history
        for keys in (
            {},
            {"growth": {"control": "load"}},
            {"kinematics": "finite"},
        )
    )
    for name in ("K_I", "K_II", "G", "J"):
        scale = float(rest["K_I" if name == "K_II" else name][0, 0])
        np.testing.assert_allclose(growth[name][0], rest[name][0], rtol=0, atol=0.01 * scale)
    np.testing.assert_allclose(finite.J[-1], rest.J[0], rtol=3e-3)


def test_the_spline_of_an_edge_crack(tmp_path):
    """G from energies of a FEM with quadratic triangles on a fine grid, and its K_II."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    cad = gmsh.model.geo
    corners = [cad.addPoint(x, y, 0, 0.1) for x, y in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]
    at = [(-1, 0), (-0.5, 0.12), (0, 0.3)]
    mouth, middle, tip = (cad.addPoint(x, y, 0, 0.01) for x, y in at)
    ends = [*corners, mouth, corners[0]]
    lines = [cad.addLine(a, b) for a, b in pairwise(ends)]
    crack = cad.addSpline([mouth, middle, tip])
    cad.addPlaneSurface([cad.addCurveLoop(lines)])
    cad.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, 1)
    for name, curve in {"bottom": lines[0], "top": lines[2], "crack": crack}.items():
        gmsh.model.addPhysicalGroup(1, [curve], name=name)
    gmsh.model.addPhysicalGroup(2, [1])
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "a.msh"))
    gmsh.finalize()
    body = {"mesh_file": {"file": str(tmp_path / "a.msh"), "cracks": ["crack"]}}
    history = run(scene_from_dict(scene(body) | {"loads": [PULL[0], PULL[2]]})).history
    assert float(history.G[0, 0]) == pytest.approx(0.01461, rel=0.01)
    assert float(history.J[0, 0]) == pytest.approx(0.01461, rel=0.01)
    assert abs(float(history.K_II[0, 0])) == pytest.approx(1.85, abs=0.05)
    assert float(history.domain_radius[0, 0, 0]) > 0.2


@pytest.mark.parametrize("kinematics", ["small", "finite"])
def test_closed_faces_that_slide_along_the_arc(tmp_path, kinematics):
    """Pressure and shear: J of all rings is K_II^2 / E'."""
    body = as_mesh_file(tmp_path / "a.msh", 45, 0.2)
    shear, press = 3.0, STRESS
    loads = [
        {"edge": name, "traction": [-press * x + shear * y, -press * y + shear * x]}
        for name, x, y in [("bottom", 0, -1), ("right", 1, 0), ("top", 0, 1), ("left", -1, 0)]
    ]
    radii = {"fracture": {"radii": [1.2, 2.0, 4.0, 7.0]}}
    by_k = run(scene_from_dict(scene(body, **radii) | {"loads": loads})).history
    history = by_k
    if kinematics == "finite":
        finite = scene(body, kinematics="finite", **radii) | {"loads": loads}
        history = run(scene_from_dict(finite)).history
    g = by_k.G.values[0]
    assert (np.abs(by_k.K_I[0]) < 0.01 * np.abs(by_k.K_II[0])).all()
    np.testing.assert_allclose(history.J_radius[-1], g[:, None] * np.ones(4), rtol=0.03)
    assert (np.ptp(history.J_radius.values[-1], axis=1) < 0.015 * g).all()
