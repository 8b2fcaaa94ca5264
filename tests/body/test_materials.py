"""Out-of-plane stress of the laws."""

from __future__ import annotations

import numpy as np
import pytest

from cfmpm.body.materials import Materials, material_table, stress_across
from cfmpm.body.points import DeformedPoints
from cfmpm.kernels.laws import dispatch

LAM, MU = 1.2e5, 8e4
YIELD, HARDENING = 300.0, 1e3
EYE = np.eye(2)


def energies(law, F, across, zz=0.0):
    """Stored energy per reference volume of an in-plane F and an out-of-plane stretch.

    For j2, `zz` is the out-of-plane logarithmic plastic strain, and F the in-plane elastic part.
    """
    J = np.linalg.det(F) * across
    ln = np.log(J)
    if law in ("hencky", "j2"):
        in_plane = np.log(np.linalg.svd(F)[1])
        strains = np.array([*in_plane, np.log(across) - zz])
        return 0.5 * LAM * strains.sum() ** 2 + MU * (strains**2).sum()
    shear = 0.5 * MU * ((F * F).sum() + across**2 - 3 - 2 * ln)
    return shear + LAM * (0.5 * ln**2 if law == "neo_hookean" else 0.25 * (J * J - 1 - 2 * ln))


def derivative(law, F, zz=0.0, h=1e-3):
    """dW/dl of the out-of-plane stretch l at l = 1, by differences of fourth order."""
    values = [energies(law, F, 1.0 + k * h, zz) for k in (-2, -1, 1, 2)]
    return (8 * (values[2] - values[1]) - (values[3] - values[0])) / (12 * h)


def table(*words, lam=None, plastic=(YIELD, HARDENING)) -> Materials:
    """One region for each law."""
    lam = np.full(len(words), LAM) if lam is None else lam
    E, nu = MU * (3 * lam + 2 * MU) / (lam + MU), lam / (2 * (lam + MU))
    rows = [
        {"E": E[i], "nu": nu[i], "law": word}
        | (dict(zip(("yield_stress", "hardening"), plastic, strict=True)) if word == "j2" else {})
        for i, word in enumerate(words)
    ]
    return material_table(rows, "strain")


def points_of(gradients, stress, material):
    n = len(gradients)
    return DeformedPoints(
        position=np.zeros((n, 2)),
        volume=np.ones(n),
        element=np.zeros(n, np.int64),
        material=material,
        displacement_gradient=gradients,
        stress=stress,
        energy=np.zeros(n),
        internal_variables=np.zeros((n, 0)),
    )


def cauchy(law, H, internal=None):
    """In-plane Cauchy stress and new internal variables of one point without patches."""
    y = np.linalg.det(EYE + H) - 1.0
    internal = np.zeros((1, 6)) if internal is None else internal
    materials = table(law)
    tau, _, _, state = dispatch.respond(
        materials.law[0], materials.constants, 0, tuple(H.ravel()), y, False, internal, 0
    )
    return np.array(tau) / (1.0 + y), np.array(state)


def gradients():
    rng = np.random.default_rng(7)
    return np.concatenate([scale * rng.uniform(-1, 1, (8, 2, 2)) for scale in (1e-3, 0.1, 0.45)])


@pytest.mark.parametrize("law", ["hencky", "neo_hookean", "ciarlet"])
def test_stress_across_is_the_derivative_of_the_energy(law):
    """sigma_zz = (dW/dl) / J at plane strain."""
    H = gradients()
    stress = np.array([cauchy(law, h)[0] for h in H])
    found = stress_across(table(law), points_of(H, stress, np.zeros(len(H), np.int64)))
    F = EYE + H
    expected = [derivative(law, f) / np.linalg.det(f) for f in F]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * MU)


def test_stress_across_where_material_has_flowed():
    """tau_zz = lambda ln J + 2 mu eps_zz with the elastic strain after plastic flow."""
    for H in gradients():
        _, state = cauchy("j2", H)
        # Back a little, from there on elastic.
        for part in (1.0, 0.9):
            back = part * H
            now, last = cauchy("j2", back, state[None])
            (found,) = stress_across(
                table("j2"), points_of(back[None], now[None], np.zeros(1, int))
            )
            J = np.linalg.det(EYE + back)
            expected = (LAM * np.log(J) + MU * np.log1p(last[3])) / J
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * MU)
        if np.abs(H).max() > 0.01:
            assert abs(state[3]) > 1e-3


def test_materials_of_points_are_told_apart():
    """One point of each law in one table, in any order."""
    lam = np.array([1.0, 2.0, 3.0, 4.0]) * LAM
    materials = table("ciarlet", "j2", "hencky", "neo_hookean", lam=lam, plastic=(1e9, 0.0))
    H = np.array([[0.2, 0.1], [-0.05, 0.15]])
    material = np.array([2, 0, 3, 1, 0])
    J = np.linalg.det(EYE + H)
    stress = []
    for m in material:
        law, constants = materials.law[m], materials.constants
        tau, *_ = dispatch.respond(
            law, constants, m, tuple(H.ravel()), J - 1, False, np.zeros((1, 6)), 0
        )
        stress.append(np.array(tau) / J)
    found = stress_across(materials, points_of(np.tile(H, (5, 1, 1)), np.array(stress), material))
    volumetric = [
        dispatch.volumetric(law, materials.constants, m, J - 1)[1]
        for m, law in enumerate(materials.law)
    ]
    np.testing.assert_allclose(found, np.array(volumetric)[material], rtol=1e-12)
