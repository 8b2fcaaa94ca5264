"""J2 plasticity at finite strain against closed forms and independent integrations of its flow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_laws import EYE, GRADIENTS, LAM, MU, difference, nominal, respond, rotation, tangent

YIELD, HARDENING = 300.0, 1e3
VIRGIN = np.zeros((1, 6))


def respond_j2(F, internal, plastic=(YIELD, HARDENING)):
    return respond("j2", F - EYE, internal=internal, plastic=plastic)


def follow(path, plastic=(YIELD, HARDENING)):
    """Kirchhoff stress, energy and state at the end of a sequence of deformation gradients."""
    internal = VIRGIN
    for F in path:
        tau, energy, _, state = respond_j2(F, internal, plastic)
        internal = state[None]
    return tau, energy, state


def random_states(seed, n):
    """States reached by three random steps, of which the last is returned with its start."""
    rng = np.random.default_rng(seed)
    while n:
        F, internal = EYE, VIRGIN
        for size in (*rng.choice([0.003, 0.05, 0.3], 2), 0.0):
            if size:
                F = F + rng.uniform(-size, size, (2, 2))
                internal = respond_j2(F, internal)[3][None]
        F = F + rng.choice([0.001, 0.05, 0.3]) * rng.uniform(-1, 1, (2, 2))
        if np.linalg.det(F) > 0.1:
            n -= 1
            yield F, internal


def test_inside_the_yield_surface_it_is_hencky_to_the_bit():
    internal = np.zeros((1, 6))
    for H in GRADIENTS:
        elastic = respond("hencky", H)
        ours = respond("j2", H, internal=internal, plastic=(1e9, 0.0))
        for ours_part, part in zip(ours[:3], elastic[:3], strict=True):
            np.testing.assert_array_equal(ours_part, part)
        assert not ours[3].any()


def test_stress_and_tangent_are_derivatives():
    """Stored energy plus plastic work of a step is a potential of P; its Hessian is the tangent."""
    yielding = 0
    for F, internal in random_states(1, 60):
        options = {"internal": internal, "plastic": (YIELD, HARDENING)}
        H = F - EYE
        state = respond("j2", H, **options)[3]
        yielding += state[4] > internal[0, 4]
        P = nominal("j2", H, **options)
        A = tangent("j2", H, **options)

        def potential(H, options=options):
            _, energy, _, state = respond("j2", H, **options)
            return energy + state[5]

        def stress(H, options=options):
            return nominal("j2", H, **options)

        # Small enough that none of the states crosses into yielding.
        np.testing.assert_allclose(difference(potential, H, 1e-5), P, atol=1e-8 * MU)
        np.testing.assert_allclose(difference(stress, H, 1e-5), A, atol=1e-6 * abs(A).max())
    assert yielding > 40


def test_plastic_flow_keeps_the_volume():
    rng = np.random.default_rng(3)
    F, internal = EYE, VIRGIN
    for _ in range(300):
        step = rng.uniform(-0.03, 0.03, (2, 2))
        F = F @ (EYE + step)
        internal = respond_j2(F, internal)[3][None]
        xx, yy, xy, zz = internal[0, :4]
        det = ((1 + xx) * (1 + yy) - xy * xy) * (1 + zz)
        np.testing.assert_allclose(det, 1.0, atol=1e-12)
    assert internal[0, 4] > 1.0


def test_frame_indifferent_with_history():
    """Cp^-1 is a tensor of the reference configuration: a rotation does not change it."""
    for F, internal in random_states(4, 20):
        R = rotation(np.deg2rad(170))
        tau, energy, _, state = respond_j2(F, internal)
        turned, same, _, same_state = respond_j2(R @ F, internal)
        np.testing.assert_allclose(turned, R @ tau @ R.T, atol=1e-10 * MU)
        np.testing.assert_allclose(same, energy, atol=1e-10 * MU)
        np.testing.assert_allclose(same_state, state, atol=1e-10)


@pytest.mark.parametrize("steps", [1, 50])
@pytest.mark.parametrize("hardening", [0.0, 1e3, 1e5])
def test_isochoric_stretch(steps, hardening):
    """F = diag(l, 1/l): q = 2 sqrt(3) mu e - 3 mu alpha = yield + H alpha, in any number of steps.

    The direction of flow is constant, so the backward Euler rule is exact.
    """
    e = np.linspace(0, 0.4, steps + 1)[1:]
    path = np.exp(e)[:, None, None] * np.diag([1.0, 0.0])
    path = path + np.exp(-e)[:, None, None] * np.diag([0.0, 1.0])
    tau, energy, state = follow(path, (YIELD, hardening))
    alpha = (2 * np.sqrt(3) * MU * e[-1] - YIELD) / (3 * MU + hardening)
    q = YIELD + hardening * alpha
    np.testing.assert_allclose(tau, q / np.sqrt(3) * np.diag([1.0, -1.0]), rtol=1e-11, atol=1e-7)
    np.testing.assert_allclose(state[4], alpha, rtol=1e-12)
    np.testing.assert_allclose(energy, q * q / (6 * MU), rtol=1e-11)
    np.testing.assert_allclose(state[5], YIELD * alpha + hardening * alpha**2 / 2, rtol=1e-12)


@pytest.mark.parametrize("hardening", [0.0, 1e3])
def test_tension_with_free_side(hardening):
    """Along a path integrated in rates of principal logarithmic strain, side free of stress.

    Without hardening the stress ends at the limit 2 / sqrt(3) of the yield stress.
    """
    C = LAM + 2 * MU * np.eye(3)

    def rates(_, values):
        *tau, alpha = values[1:]
        dev = np.array(tau) - np.mean(tau)
        q = np.sqrt(1.5 * (dev @ dev))
        D = C
        if q >= (YIELD + hardening * alpha) * (1 - 1e-9):
            N = 1.5 * dev / q
            D = C - np.outer(2 * MU * N, 2 * MU * N) / (3 * MU + hardening)
        d_yy = -D[1, 0] / D[1, 1]
        d_tau = D[:, 0] + D[:, 1] * d_yy
        d_alpha = 0.0 if D is C else 2 * MU * (N @ [1.0, d_yy, 0.0]) / (3 * MU + hardening)
        return [d_yy, *d_tau, d_alpha]

    # Up to first yield the ratio of lateral to axial strain is that of elasticity.
    ratio = -LAM / (LAM + 2 * MU)
    unit = C @ [1.0, ratio, 0.0]
    dev = unit - unit.mean()
    first = YIELD / np.sqrt(1.5 * (dev @ dev))
    start = [ratio * first, *(unit * first), 0.0]
    eps = np.concatenate([np.linspace(0, first, 3)[1:-1], np.geomspace(first, 0.3, 2000)])
    yielding = eps >= first
    solution = solve_ivp(
        rates, (first, 0.3), start, t_eval=eps[yielding], rtol=1e-10, atol=1e-12, method="LSODA"
    )
    assert solution.success
    lateral = np.concatenate([ratio * eps[~yielding], solution.y[0]])
    path = [np.diag(np.exp([xx, yy])) for xx, yy in zip(eps, lateral, strict=True)]
    tau, _, state = follow(path, (YIELD, hardening))
    axial, alpha = solution.y[1, -1], solution.y[4, -1]
    np.testing.assert_allclose(tau, np.diag([axial, 0.0]), atol=1e-3 * axial)
    np.testing.assert_allclose(state[4], alpha, rtol=1e-3)
    if hardening == 0.0:
        np.testing.assert_allclose(axial, 2 / np.sqrt(3) * YIELD, rtol=1e-3)


def test_simple_shear():
    """Principal axes turn: Cp^-1 integrated by its own flow rule, three-dimensional matrices.

    d Cp^-1 = -2 F^-1 (N b_e) F^-T d alpha with N = 3/2 dev tau / q, d alpha from consistency by
    differences of q(F, Cp^-1).
    """
    hardening = 1e3

    def deformation(shear):
        F = np.eye(3)
        F[0, 1] = shear
        return F

    def stress(F, Ci):
        values, axes = np.linalg.eigh(F @ Ci @ F.T)
        eps = axes @ np.diag(0.5 * np.log(values)) @ axes.T
        tau = LAM * np.trace(eps) * np.eye(3) + 2 * MU * eps
        dev = tau - np.trace(tau) / 3 * np.eye(3)
        return tau, dev, np.sqrt(1.5 * (dev * dev).sum())

    def rates(shear, values):
        F, Ci = deformation(shear), values[:9].reshape(3, 3)
        _, dev, q = stress(F, Ci)
        G = np.linalg.inv(F)
        flow = -2 * G @ (1.5 * dev / q) @ F @ Ci
        flow = 0.5 * (flow + flow.T)
        h = 1e-6
        ends = [stress(deformation(shear + s), Ci)[2] for s in (-h, h)]
        by_shear = (ends[1] - ends[0]) / (2 * h)
        by_flow = (stress(F, Ci + h * flow)[2] - stress(F, Ci - h * flow)[2]) / (2 * h)
        d_alpha = by_shear / (hardening - by_flow)
        return [*(flow * d_alpha).ravel(), d_alpha]

    first = brentq(lambda s: stress(deformation(s), np.eye(3))[2] - YIELD, 1e-6, 0.1, xtol=1e-15)
    shears = np.concatenate([[first], np.geomspace(first, 1.0, 3000)[1:]])
    solution = solve_ivp(rates, (first, 1.0), [*np.eye(3).ravel(), 0.0], rtol=1e-9, atol=1e-12)
    assert solution.success
    Ci, alpha = solution.y[:9, -1].reshape(3, 3), solution.y[9, -1]
    reference, _, q = stress(deformation(1.0), Ci)
    np.testing.assert_allclose(q, YIELD + hardening * alpha, rtol=1e-5)
    tau, _, state = follow([deformation(s)[:2, :2] for s in shears])
    np.testing.assert_allclose(tau, reference[:2, :2], atol=1e-3 * q)
    np.testing.assert_allclose(state[4], alpha, rtol=1e-3)
    ours = [1 + state[0], 1 + state[1], state[2], 1 + state[3]]
    np.testing.assert_allclose(ours, [Ci[0, 0], Ci[1, 1], Ci[0, 1], Ci[2, 2]], atol=1e-3)


def test_unloading_is_elastic_and_reload_yields_where_it_left():
    path = [np.diag([np.exp(e), np.exp(-e)]) for e in (0.01, 0.02, 0.03, 0.029)]
    tau, _, state = follow(path[:3])
    back, _, same = follow(path)
    np.testing.assert_array_equal(same, state)
    np.testing.assert_allclose((tau - back)[0, 0], 2 * MU * 0.001, rtol=1e-9)
    again, _, state_again = follow([*path, path[2]])
    np.testing.assert_allclose(again, tau, rtol=1e-10, atol=1e-7)
    np.testing.assert_allclose(state_again, state, rtol=1e-10, atol=1e-14)
