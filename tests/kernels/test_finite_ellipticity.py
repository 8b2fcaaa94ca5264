"""Loss of ellipticity: closed forms, and a search over all pairs of directions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from test_laws import ELASTIC, EYE, LAM, MU, nominal, respond, tangent, volumetric

from cfmpm.kernels import acoustic
from cfmpm.kernels.laws import dispatch

ALONE = np.zeros(0, np.int64)
NU = LAM / (2 * (LAM + MU))


def ellipticity(law, F, internal=None, patch=ALONE, parameters=(LAM, MU, 300.0, 1e3)):
    F = np.atleast_3d(F).reshape(-1, 2, 2)
    n = len(F)
    return acoustic.ellipticity(
        np.ones(n),
        np.zeros(n, np.int64),
        np.array([dispatch.NUMBERS[law]]),
        np.array([parameters]),
        np.zeros((n, 6)) if internal is None else internal,
        F - EYE,
        patch,
    )


def by_search(A, mu=MU):
    """Smallest eigenvalue of A_iJkL N_J N_L over many directions N."""
    angle = np.linspace(0, np.pi, 20001)
    N = np.array([np.cos(angle), np.sin(angle)])
    return np.linalg.eigvalsh(np.einsum("iJkL,Jn,Ln->nik", A, N, N)).min() / mu


@pytest.mark.parametrize("law", [*ELASTIC, "j2"])
def test_without_strain_it_is_one(law):
    np.testing.assert_allclose(ellipticity(law, EYE), 1.0, rtol=1e-14)


@settings(max_examples=100)
@given(
    law=st.sampled_from([*ELASTIC, "j2"]),
    seed=st.integers(0, 10**6),
    size=st.sampled_from([1e-9, 1e-3, 0.1, 0.6, 3.0]),
)
def test_no_direction_is_missed(law, seed, size):
    F = EYE + np.random.default_rng(seed).uniform(-size, size, (2, 2))
    if np.linalg.det(F) < 0.05:
        F[0] = -F[0]
    if np.linalg.det(F) < 0.05:
        return
    internal = np.zeros((1, 6))
    A = tangent(law, F - EYE, internal=internal)
    lowest = by_search(A)
    scale = abs(A).max() / MU
    # The grid of directions is off by at most the curvature times half its step squared.
    ours = ellipticity(law, F, internal)[0]
    assert ours <= lowest + 1e-12 * scale
    assert ours >= lowest - 1e-7 * scale


@settings(max_examples=300)
@given(
    values=st.lists(
        st.sampled_from([0.0, 1e-12, 1.0, -1.0]) | st.floats(-2, 2), min_size=5, max_size=5
    )
)
@example(values=[-1.0, 0.0, 0.0, 5e-324, 1.0])
@example(values=[-1.0, 0.0, 0.0, 1e-300, 0.5])
@example(values=[-1.0, 0.0, 0.0, 1e-16, 1.0])
def test_quadratic_on_the_circle(values):
    """Also degenerate cases: w = 0, w normal to the axis, M a multiple of the unit matrix."""
    mxx, myy, mxy, wx, wy = values

    def quadratic(x, y):
        return mxx * x * x + myy * y * y + 2 * mxy * x * y + 2 * (wx * x + wy * y)

    x, y = acoustic.lowest_on_circle(*values)
    np.testing.assert_allclose(np.hypot(x, y), 1.0, rtol=1e-14)
    angle = np.linspace(0, 2 * np.pi, 5001)
    assert quadratic(x, y) <= quadratic(np.cos(angle), np.sin(angle)).min() + 1e-12


def test_equibiaxial_limit_of_hencky():
    """c_1111 + tau = lambda + 2 mu - 2 (lambda + mu) ln l is zero at l = exp(1 - nu)."""
    limit = np.exp(1 - NU)
    for stretch in (1.2, 1.8, 2.0, limit, 2.5):
        along = LAM + 2 * MU - 2 * (LAM + MU) * np.log(stretch)
        expected = min(along, MU) / stretch**2 / MU
        across = 1.0 / stretch**2
        np.testing.assert_allclose(
            ellipticity("hencky", stretch * EYE), min(expected, across), atol=1e-14
        )


def free_side(law, stretch):
    """Tension with the side free of stress."""

    def stress(side):
        return nominal(law, np.diag([stretch, side]) - EYE)[1, 1]

    return np.diag([stretch, brentq(stress, 0.02, 1.2, xtol=1e-15, rtol=1e-14)])


def test_uniaxial_limit_of_hencky():
    """nu = 0.3: between the two stretches an oblique direction is lost, also by search."""
    for stretch, lost in ((3.0, False), (3.09, False), (3.11, True), (3.3, True)):
        F = free_side("hencky", stretch)
        assert (by_search(tangent("hencky", F - EYE)) < 0) == lost
        assert (ellipticity("hencky", F)[0] < 0) == lost


@pytest.mark.parametrize("law", ["neo_hookean", "ciarlet"])
def test_neo_hookean_keeps_it(law):
    for stretch in np.linspace(1.0, 5.0, 17):
        for F in (stretch * EYE, free_side(law, stretch), np.diag([stretch, 1 / stretch])):
            assert ellipticity(law, F)[0] > 0


def test_only_ciarlet_keeps_it_near_incompressibility():
    """(ln J)^2 is concave beyond J = e, where a small mu cannot compensate."""
    nearly = (100 * MU, MU, 0.0, 0.0)
    assert ellipticity("neo_hookean", 3.0 * EYE, parameters=nearly)[0] < 0
    for stretch in (3.0, 30.0):
        assert ellipticity("ciarlet", stretch * EYE, parameters=nearly)[0] > 0


def test_an_inverted_point_has_lost_it():
    F = np.array([EYE, np.diag([-0.5, 1.0])])
    for law in ELASTIC:
        np.testing.assert_array_equal(ellipticity(law, F) > 0, [True, False])


def test_yielding_lowers_it():
    """Perfectly plastic flow has almost no shear stiffness."""
    F = np.diag([1.02, 1 / 1.02])
    _, _, _, state = respond("j2", F - EYE, internal=np.zeros((1, 6)))
    assert state[4] > 0
    assert ellipticity("j2", F, parameters=(LAM, MU, 300.0, 0.0))[0] < 0.02
    assert ellipticity("hencky", F)[0] > 0.9


@pytest.mark.parametrize("law", ELASTIC)
def test_with_patches_the_pressure_is_that_of_the_mean(law):
    F = np.array([1.8 * EYE, np.diag([1.5, 0.9])])
    J = np.linalg.det(F)
    mean = J.mean() - 1.0
    bulk = volumetric(law, mean)[2]
    expected = []
    for f, j in zip(F, J, strict=True):
        G = np.linalg.inv(f)
        own = bulk * j * j * np.einsum("Ji,Lk->iJkL", G, G)
        expected.append(by_search(tangent(law, f - EYE, mean=mean) + own))
    np.testing.assert_allclose(ellipticity(law, F, patch=np.array([0, 0])), expected, atol=1e-7)
