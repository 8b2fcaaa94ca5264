"""A hyperelastic law with three constants that another package adds: Mooney-Rivlin."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

# W = c_10 (I_1 - 3) + c_01 (I_2 - 3) - (2 c_10 + 4 c_01) ln J + d/2 (J - 1)^2.
LAW = """
from cfmpm._jit import kernel
from cfmpm.kernels.laws.tensors import log_defect
from cfmpm.registry.laws import Constant, Law

MOONEY_RIVLIN = Law(
    "Mooney-Rivlin law",
    "rubber_law",
    (
        Constant("c_10", "of mooney_rivlin [MPa]", above=0),
        Constant("c_01", "of mooney_rivlin [MPa]", 0.0, least=0),
        Constant("d", "of mooney_rivlin: resistance to change of volume [MPa]", above=0),
    ),
    elliptic=True,
)


@kernel
def volumetric(d, y):
    return 0.5 * d * y * y, d * y, 1.0 * d


@kernel
def response(c_10, c_01, H, y):
    hxx, hxy, hyx, hyy = H
    mu, square = 2.0 * (c_10 + c_01), y * (2.0 + y)  # J^2 - 1
    tau = (
        mu * (2.0 * hxx + hxx * hxx + hxy * hxy) + 2.0 * c_01 * square,
        mu * (2.0 * hyy + hyx * hyx + hyy * hyy) + 2.0 * c_01 * square,
        mu * (hxy + hyx + hxx * hyx + hxy * hyy),
    )
    twice = 2.0 * log_defect(y)
    shape = (hxx - hyy) ** 2 + (hxy + hyx) ** 2
    energy = 0.5 * mu * (shape + twice) + c_01 * (y * y + twice)
    push = mu - 2.0 * c_01 * square
    along = 2.0 * push + 4.0 * c_01 * (1.0 + square)
    return tau, energy, (along, along, 4.0 * c_01 * (1.0 + square), 0.0, 0.0, push)


@kernel
def across(c_01, H, tau):
    hxx, hxy, hyx, hyy = H
    return 2.0 * c_01 * (2.0 * (hxx + hyy) + hxx**2 + hxy**2 + hyx**2 + hyy**2)
"""

BEGIN = """
import sys
import numpy as np
import cfmpm

c_10, c_01, d = 0.4, 0.15, 3.0
mu, lam = 2 * (c_10 + c_01), 4 * c_01 + d
material = {
    "E": mu * (3 * lam + 2 * mu) / (lam + mu),
    "nu": lam / (2 * (lam + mu)),
    "law": "mooney_rivlin",
    "c_10": c_10,
    "c_01": c_01,
    "d": d,
}


def W(F):
    b = F @ F.T
    J, I_1 = np.linalg.det(F), np.trace(b)
    I_2 = 0.5 * (I_1**2 - np.trace(b @ b))
    ln = (2 * c_10 + 4 * c_01) * np.log(J)
    return c_10 * (I_1 - 3) + c_01 * (I_2 - 3) - ln + 0.5 * d * (J - 1) ** 2


def slope(function, F, i, j, h):
    D = np.zeros((3, 3))
    D[i, j] = h
    near, far = function(F + D) - function(F - D), function(F + 2 * D) - function(F - 2 * D)
    return (8 * near - far) / (12 * h)


def cauchy(F):
    P = np.array([[slope(W, F, i, j, 1e-3) for j in range(3)] for i in range(3)])
    return P @ F.T / np.linalg.det(F)


def in_space(H):
    F = np.eye(3)
    F[:2, :2] += H
    return F
"""

# Stress, tangent and sigma_zz of a point, by differences of the energy in three dimensions.
POINT = (
    BEGIN
    + """
from cfmpm.body.materials import material_table
from cfmpm.kernels.laws import dispatch

table = material_table([material, material | {"law": "hencky"}], "strain")
assert table.constants.shape == (2, 5), table.constants
law, nothing = dispatch.NUMBERS["mooney_rivlin"], np.zeros((1, 0))


def respond(H):
    y = np.linalg.det(np.eye(2) + H) - 1
    return dispatch.respond(law, table.constants, 0, tuple(H.ravel()), y, False, nothing, 0)


rng = np.random.default_rng(1)
for size in (1e-9, 0.05, 0.4):
    for _ in range(5):
        H = size * rng.uniform(-1, 1, (2, 2))
        F = in_space(H)
        J = np.linalg.det(F)
        tau, energy, c, _ = respond(H)
        found = np.array([[tau[0], tau[2]], [tau[2], tau[1]]])
        np.testing.assert_allclose(found / J, cauchy(F)[:2, :2], atol=1e-10)
        np.testing.assert_allclose(energy, W(F), atol=1e-14)
        stress = tuple(np.array(tau) / J)
        across = dispatch.stress_across(law, table.constants, 0, tuple(H.ravel()), J - 1, stress)
        np.testing.assert_allclose(across, cauchy(F)[2, 2], atol=1e-10)

        def P(F):
            tau = respond(F[:2, :2] - np.eye(2))[0]
            tau = np.array([[tau[0], tau[2]], [tau[2], tau[1]]])
            return tau @ np.linalg.inv(F[:2, :2]).T

        voigt = np.array([[c[0], c[2], c[3]], [c[2], c[1], c[4]], [c[3], c[4], c[5]]])
        at = np.array([[0, 2], [2, 1]])
        A = voigt[at[:, :, None, None], at[None, None]] + np.einsum("ik,jl->ijkl", np.eye(2), found)
        G = np.linalg.inv(F[:2, :2])
        A = np.einsum("ijkl,Jj,Ll->iJkL", A, G, G)
        for k, L in np.ndindex(2, 2):
            np.testing.assert_allclose(A[:, :, k, L], slope(P, F, k, L, 1e-3), atol=1e-9)
print(respond(np.full((2, 2), 0.1))[1], sum(dispatch.respond.stats.cache_hits.values()))
"""
)

# A strip pulled to one and a half times its length, its sides free.
STRIP = (
    BEGIN
    + """
from scipy.optimize import brentq

strip = {
    "name": "strip",
    "geometry": {"outline": [
        {"at": [0, 0], "edge": "bottom"}, {"at": [2, 0], "edge": "right"},
        {"at": [2, 3], "edge": "top"}, {"at": [0, 3], "edge": "left"},
    ]},
    "kinematics": "finite",
    "mesh": {"size": 0.7},
    "material": material,
    "load_steps": 2,
    "loads": [
        {"edge": "bottom", "displacement": {"y": 0}},
        {"edge": "left", "displacement": {"x": 0}},
        {"edge": "top", "displacement": {"y": 1.5}},
    ],
    "output": {"fields": True},
}
result = cfmpm.run(cfmpm.scene_from_dict(strip))
narrow = brentq(lambda a: cauchy(np.diag([a, 1.5, 1.0]))[0, 0], 0.5, 1.0, xtol=1e-14)
F = np.diag([narrow, 1.5, 1.0])
H = result.points.displacement_gradient
np.testing.assert_allclose(H, np.broadcast_to((F - np.eye(3))[:2, :2], H.shape), atol=1e-9)
expected = cauchy(F)
np.testing.assert_allclose(result.points.stress - [0, expected[1, 1], 0], 0, atol=1e-8)
np.testing.assert_allclose(result.points.energy, W(F), rtol=1e-9)
np.testing.assert_allclose(result.history.strain_energy[-1], 6 * W(F), rtol=1e-9)

from cfmpm.body.materials import stress_across

across = stress_across(result.body.materials, result.points)
np.testing.assert_allclose(across, expected[2, 2], rtol=1e-8)

# With a crack the field is not uniform. Newton's method is quadratic: a tangent that is wrong by
# a thousandth leaves a thousandth of the residual, not its square.
crack = {"name": "slit", "points": [[0, 1.5], [0.6, 1.5]]}
strip["geometry"]["cracks"] = [crack]
strip["load_steps"] = [0.2]
residuals = np.array(cfmpm.run(cfmpm.scene_from_dict(strip)).balance.residuals)
assert 1e-8 < residuals[-2] < 1e-4 and residuals[-1] < 20 * residuals[-2] ** 2, residuals

for change, said in (
    ({"c_10": None}, "material.c_10: is missing: the law mooney_rivlin needs it"),
    ({"law": "hencky"}, "material.c_10: does not fit: the law hencky has none"),
    ({"d": -1}, "material.d: must be greater than 0"),
    ({"yield_stress": 1}, "material.yield_stress: does not fit: the law mooney_rivlin is elastic"),
    ({"d": 4}, "material: the stiffness of mooney_rivlin at zero strain differs by"),
):
    given = {key: value for key, value in (material | change).items() if value is not None}
    try:
        cfmpm.run(cfmpm.scene_from_dict(strip | {"material": given}))
    except cfmpm.SceneError as error:
        assert said in str(error), error
    else:
        raise AssertionError(said)
"""
)


def run(folder: Path, program: str, **environment: str) -> str:
    path = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": path, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installed package with the law: one file and one entry point."""
    folder = tmp_path_factory.mktemp("package")
    (folder / "rubber_law.py").write_text(LAW)
    facts = folder / "rubber_law-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: rubber-law\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text(
        "[cfmpm.laws]\nmooney_rivlin = rubber_law:MOONEY_RIVLIN\n"
    )
    return folder


def test_stress_and_tangent_are_derivatives(package: Path) -> None:
    run(package, POINT)


def test_uniform_extension_and_a_crack(package: Path) -> None:
    run(package, STRIP)


def test_machine_code_is_kept_until_the_law_changes(package: Path, tmp_path: Path) -> None:
    own = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    energy, hits = map(float, run(package, POINT, **own).split())
    again, more = map(float, run(package, POINT, **own).split())
    assert (again, hits, more > 0) == (energy, 0, True)
    changed = tmp_path / "changed"
    changed.mkdir()
    (changed / "rubber_law.py").write_text(LAW.replace("0.5 * mu * (shape", "0.6 * mu * (shape"))
    program = POINT[: POINT.index("rng = ")] + POINT[POINT.index("print(") :]
    path = f"{changed}{os.pathsep}{package}"
    same_folder = run(Path(path), program, **own).split()
    assert float(same_folder[0]) > 1.05 * energy
