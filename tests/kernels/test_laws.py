"""Laws at finite deformation against finite differences, published formulas and small strain."""

from __future__ import annotations

import numpy as np
import pytest
import round_off
from hooke import plane_matrix
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm_frechet

from cfmpm.kernels import constitutive
from cfmpm.kernels.laws import dispatch
from cfmpm.kernels.laws.tensors import log_defect
from cfmpm.registry.laws import LAWS

LAM, MU = 1.2e5, 8e4
# All that need no constants besides Hooke's.
ELASTIC = [word for word, law in LAWS.items() if not law.constants]
VOIGT = np.array([[0, 2], [2, 1]])
# Volumetric energies over lambda, from the papers.
U = {
    "hencky": lambda J: 0.5 * np.log(J) ** 2,
    "j2": lambda J: 0.5 * np.log(J) ** 2,
    "neo_hookean": lambda J: 0.5 * np.log(J) ** 2,
    "ciarlet": lambda J: 0.25 * (J * J - 1) - 0.5 * np.log(J),
}
NO_INTERNAL = np.zeros((1, 0))
EYE = np.eye(2)


def rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def respond(law, H, *, mean=None, lam=LAM, mu=MU, plastic=(300.0, 1e3), internal=NO_INTERNAL):
    """Kirchhoff stress, energy, c_ijkl and state of one point from its displacement gradient."""
    H = np.asarray(H, float)
    y = H[0, 0] + H[1, 1] + (H[0, 0] * H[1, 1] - H[0, 1] * H[1, 0])
    at, patched = (y, False) if mean is None else (mean, True)
    constants = np.array([[lam, mu, *plastic]])
    tau, energy, c, state = dispatch.respond(
        dispatch.NUMBERS[law], constants, 0, tuple(H.ravel()), at, patched, internal, 0
    )
    c = np.array([[c[0], c[2], c[3]], [c[2], c[1], c[4]], [c[3], c[4], c[5]]])
    c = c[VOIGT[:, :, None, None], VOIGT[None, None]]
    return np.array(tau)[VOIGT], energy, c, np.array(state)


def volumetric(law, y):
    return dispatch.volumetric(dispatch.NUMBERS[law], np.array([[LAM, MU, 0.0, 0.0]]), 0, y)


def nominal(law, H, **options):
    return respond(law, H, **options)[0] @ np.linalg.inv(EYE + H).T


def tangent(law, H, **options):
    """dP/dF of the law, pulled back from c_ijkl + delta_ik tau_jl."""
    tau, _, c, _ = respond(law, H, **options)
    G = np.linalg.inv(EYE + H)
    return np.einsum("ijkl,Jj,Ll->iJkL", c + np.einsum("ik,jl->ijkl", EYE, tau), G, G)


def difference(function, H, step):
    """Derivative with respect to H by differences of fourth order."""
    result = np.zeros((*np.shape(function(H)), 2, 2))
    for i, j in np.ndindex(2, 2):
        D = np.zeros((2, 2))
        D[i, j] = step
        near = function(H + D) - function(H - D)
        far = function(H + 2 * D) - function(H - 2 * D)
        result[..., i, j] = (8 * near - far) / (12 * step)
    return result


def gradients():
    """Fifty displacement gradients: random, stretches to 20, equal and nearly equal stretches."""
    rng = np.random.default_rng(5)
    stretches = [np.exp(rng.uniform(-1, 1, 2)) for _ in range(30)]
    stretches += [np.exp(rng.uniform(-3, 3, 2)) for _ in range(8)]
    stretches += [(20.0, 20.0), (20.0, 0.05), (0.05, 0.05), (20.0, 1.0)]
    for gap in (0.0, 1e-15, 1e-12, 1e-8):
        stretches += [(1.0, 1.0 + gap), (1.7, 1.7 * (1.0 + gap))]
    for first, second in stretches:
        a, b = rng.uniform(-np.pi, np.pi, 2)
        yield rotation(a) @ np.diag([first, second]) @ rotation(b) - EYE


GRADIENTS = list(gradients())


@pytest.mark.parametrize("law", ELASTIC)
@pytest.mark.parametrize("mean", [None, 0.2])
def test_stress_and_tangent_are_derivatives(law, mean):
    for H in GRADIENTS:
        smallest = np.linalg.svd(EYE + H)[1].min()
        P = nominal(law, H, mean=mean)
        by_energy = difference(lambda H: respond(law, H, mean=mean)[1], H, 1e-4 * smallest)
        np.testing.assert_allclose(P, by_energy, rtol=0, atol=1e-8 * (abs(P).max() + MU))
        A = tangent(law, H, mean=mean)
        by_stress = difference(lambda H: nominal(law, H, mean=mean), H, 1e-4 * smallest)
        np.testing.assert_allclose(A, by_stress, rtol=0, atol=1e-9 * abs(A).max())


@pytest.mark.parametrize("law", ELASTIC)
def test_tangent_of_pairs_of_equal_stretches_is_isotropic(law):
    """A divided difference computed by subtraction has an error of 2 % at a gap of 1e-15."""
    for gap in (0.0, 1e-16, 1e-15, 1e-14, 1e-10):
        _, _, c, _ = respond(law, rotation(0.3) @ np.diag([0.7, 0.7 + gap]) @ rotation(1.0))
        np.testing.assert_allclose(
            2 * c[0, 1, 0, 1], c[0, 0, 0, 0] - c[0, 0, 1, 1], rtol=1e-13 + 10 * gap
        )


def test_hencky_is_the_papers_tangent_with_misprints_put_right():
    """a_ijkl = (D : L : B)_ijkl / (2 J) - sigma_il delta_jk, L the derivative of ln b."""
    D = LAM * np.einsum("ij,kl->ijkl", EYE, EYE)
    D = D + MU * (np.einsum("ik,jl->ijkl", EYE, EYE) + np.einsum("il,jk->ijkl", EYE, EYE))
    rng = np.random.default_rng(1)
    for _ in range(30):
        F = EYE + rng.uniform(-0.5, 0.5, (2, 2))
        J = np.linalg.det(F)
        b = F @ F.T
        values, axes = np.linalg.eigh(b)
        log_b = axes @ np.diag(np.log(values)) @ axes.T
        exp_derivative = [
            expm_frechet(log_b, E.reshape(2, 2), compute_expm=False).ravel() for E in np.eye(4)
        ]
        L = np.linalg.inv(np.array(exp_derivative).T).reshape(2, 2, 2, 2)
        B = np.einsum("pk,ql->pqkl", EYE, b) + np.einsum("qk,pl->pqkl", EYE, b)
        sigma = np.einsum("ijkl,kl->ij", D, log_b) / (2 * J)
        a = np.einsum("ijmn,mnpq,pqkl->ijkl", D, L, B) / (2 * J)
        a -= np.einsum("il,jk->ijkl", sigma, EYE)
        tau, energy, c, _ = respond("hencky", F - EYE)
        ours = (c + np.einsum("ik,jl->ijkl", EYE, tau)) / J
        np.testing.assert_allclose(tau / J, sigma, atol=1e-12 * abs(sigma).max())
        np.testing.assert_allclose(ours, a, atol=1e-12 * abs(a).max())
        eps = 0.5 * log_b
        reference = 0.5 * LAM * np.trace(eps) ** 2 + MU * (eps * eps).sum()
        np.testing.assert_allclose(energy, reference, rtol=1e-12)


@pytest.mark.parametrize("law", ["neo_hookean", "ciarlet"])
def test_neo_hookean_energy(law):
    for H in GRADIENTS:
        J = np.linalg.det(EYE + H)
        reference = 0.5 * MU * (((EYE + H) ** 2).sum() - 2 - 2 * np.log(J)) + LAM * U[law](J)
        np.testing.assert_allclose(respond(law, H)[1], reference, rtol=1e-11, atol=1e-9)


@settings(max_examples=60)
@given(
    law=st.sampled_from([*ELASTIC, "j2"]),
    angle=st.floats(-np.pi, np.pi),
    first=st.floats(0.3, 3.0),
    second=st.floats(0.3, 3.0),
    axis=st.floats(-np.pi, np.pi),
)
def test_frame_indifferent_and_isotropic(law, angle, first, second, axis):
    """A rotation after the deformation rotates the stress, one before it has no effect."""
    state = {"internal": np.zeros((1, 6))}
    U = rotation(axis) @ np.diag([first, second]) @ rotation(-axis)
    R = rotation(angle)
    tau, energy, c, _ = respond(law, U - EYE, **state)
    turned, turned_energy, turned_c, _ = respond(law, R @ U - EYE, **state)
    # A state inside the yield surface holds energies far below those of volume change.
    scale = 1e-11 * (MU + abs(tau).max())
    np.testing.assert_allclose(turned, R @ tau @ R.T, atol=scale)
    np.testing.assert_allclose(turned_energy, energy, atol=scale)
    np.testing.assert_allclose(
        turned_c, np.einsum("im,jn,kp,lq,mnpq->ijkl", R, R, R, R, c), atol=10 * scale
    )
    before, same_energy, _, _ = respond(law, U @ R - EYE, **state)
    np.testing.assert_allclose(before, tau, atol=scale)
    np.testing.assert_allclose(same_energy, energy, atol=scale)


@pytest.mark.parametrize("law", [*ELASTIC, "j2"])
@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-13, 1e-10, 1e-8, 1e-6])
def test_small_strain_is_linear_elasticity(law, size):
    """At any small strain the difference to Hooke's law is of second order."""
    rng = np.random.default_rng(2)
    for direction in [*rng.uniform(-1, 1, (10, 2, 2)), EYE, np.array([[0.0, 1.0], [-1.0, 0.0]])]:
        H = size * direction
        _, stress, energy = constitutive.linear_elastic(
            np.array([[0, 1]]),
            np.array([0]),
            EYE[None],
            np.array([0]),
            plane_matrix(LAM, MU),
            np.ascontiguousarray(H.T),
        )
        tau, W, c, _ = respond(law, H, internal=np.zeros((1, 6)))
        norm = 2 * (LAM + MU) * size
        np.testing.assert_allclose(tau, stress[0][VOIGT], atol=norm * (1e-15 + 10 * size))
        np.testing.assert_allclose(W, energy[0], atol=norm * size * (1e-15 + 10 * size))
        D = LAM * np.einsum("ij,kl->ijkl", EYE, EYE)
        D = D + MU * (np.einsum("ik,jl->ijkl", EYE, EYE) + np.einsum("il,jk->ijkl", EYE, EYE))
        np.testing.assert_allclose(c, D, atol=2 * (LAM + MU) * (1e-15 + 20 * size))


@settings(max_examples=200)
@given(y=st.floats(-0.999, 1e6))
def test_log_defect(y):
    """Against extended precision and, where it cancels, its series."""
    x = np.longdouble(y)
    if abs(y) > 1e-3:
        reference = x - np.log1p(x)
    else:
        reference = x * x * sum((-x) ** k / np.longdouble(k + 2) for k in range(8))
    # At most 20 times as large as what is left, at y = 0.1, is the logarithm that is taken away; it
    # is rounded to one unit.
    np.testing.assert_allclose(log_defect(y), float(reference), rtol=2 * 20 * round_off.EPS)


def test_volumetric_laws_and_their_derivatives():
    for law in (*ELASTIC, "j2"):
        for y in (-0.9, -0.3, 0.0, 1e-9, 0.5, 20.0):
            J, h = 1.0 + y, 1e-4 * (1.0 + y)
            values = [np.array(volumetric(law, y + k * h)) for k in (-2, -1, 0, 1, 2)]
            slope = (8 * (values[3] - values[1]) - (values[4] - values[0])) / (12 * h)
            np.testing.assert_allclose(values[2][1:], slope[:2], rtol=1e-9, atol=1e-9 * LAM)
            if law in U:
                np.testing.assert_allclose(
                    values[2][0], LAM * U[law](J), rtol=1e-12, atol=1e-12 * LAM
                )


def test_patch_energy_is_continued_linearly():
    """Over a patch the deviations from the mean sum to zero."""
    for law in ELASTIC:
        H = [0.1 * EYE, -0.05 * EYE]
        y = np.array([np.linalg.det(EYE + h) - 1 for h in H])
        patched = sum(respond(law, h, mean=y.mean())[1] for h in H)
        own = sum(respond(law, h)[1] - volumetric(law, z)[0] for h, z in zip(H, y, strict=True))
        np.testing.assert_allclose(patched, own + 2 * volumetric(law, y.mean())[0], rtol=1e-12)
