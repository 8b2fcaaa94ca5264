"""The independent FEM at large strain against closed forms, without cfmpm."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from workflows.reference import large_strain_tables as plate_of_5_1
from workflows.reference import total_lagrangian as fem
from workflows.reference.total_lagrangian import equilibrium

E, NU = 210.0, 0.3
LAM, MU = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
LAWS = tuple(fem.LAWS)
ONE = np.eye(2)


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])


def states():
    """Deformation gradients: random, with (nearly) equal stretches, and with large stretches."""
    rng = np.random.default_rng(4)
    random = ONE + 0.5 * rng.standard_normal((60, 2, 2))
    twin = [np.diag([1.5, 1.5 * (1 + gap)]) for gap in (0.0, 1e-15, 1e-12, 1e-8, 1e-4, 1e-2)]
    far = [turned(50) @ np.diag([20.0, 0.06]), turned(-130) @ np.diag([0.1, 3.0]) @ turned(20)]
    return np.array([*random[np.linalg.det(random) > 0.05], ONE, *twin, *far])


def bar(element, law, width=1.0, height=2.0, n=(2, 4), shake=0.6, order=None):
    grid = build_grid(rectangle(*n, width, height, shake=shake, seed=3), element)
    return fem.make_solid(grid.nodes, grid.elements, law, E, NU, order)


def rim(solid):
    low, high = solid.nodes.min(axis=0), solid.nodes.max(axis=0)
    return np.flatnonzero(((solid.nodes == low) | (solid.nodes == high)).any(axis=1))


def end(solid, height):
    return np.flatnonzero(np.isclose(solid.nodes[:, 1], height))


@pytest.mark.parametrize("law", LAWS)
def test_stress_and_tangent_are_the_derivatives_of_the_energy(law):
    F = states()
    at = fem.respond(law, (LAM, MU), F - ONE)
    stress, tangent = np.empty_like(at.stress), np.empty_like(at.tangent)
    size = np.abs(at.tangent).max(axis=(1, 2, 3, 4))
    step = 1e-3 * np.linalg.svd(F, compute_uv=False)[:, 1]
    for i in range(2):
        for j in range(2):
            move = np.zeros_like(F)
            move[:, i, j] = step
            # Fourth order differences.
            near, far = (
                [fem.respond(law, (LAM, MU), F - ONE + k * s * move) for s in (1, -1)]
                for k in (1, 2)
            )
            for name, into in (("energy", stress), ("stress", tangent)):
                one, two = (getattr(a, name) - getattr(b, name) for a, b in (near, far))
                into[..., i, j] = (8 * one - two) / (12 * step.reshape(-1, *[1] * (one.ndim - 1)))
    np.testing.assert_allclose(
        stress / size[:, None, None], at.stress / size[:, None, None], atol=1e-9
    )
    scaled = (tangent - at.tangent) / size[:, None, None, None, None]
    assert np.abs(scaled).max() < 1e-7
    turned_over = at.tangent.transpose(0, 3, 4, 1, 2)
    assert np.abs((at.tangent - turned_over) / size[:, None, None, None, None]).max() < 1e-14


def test_energies_are_those_stated():
    F = states()
    C = np.swapaxes(F, 1, 2) @ F
    J, trace = np.linalg.det(F), np.trace(C, axis1=1, axis2=2)
    logs = 0.5 * np.log(np.linalg.eigvalsh(C))
    expected = {
        "hencky": 0.5 * LAM * logs.sum(axis=1) ** 2 + MU * (logs**2).sum(axis=1),
        "neo_hookean": 0.5 * MU * (trace - 2 - 2 * np.log(J)) + 0.5 * LAM * np.log(J) ** 2,
        "ciarlet": 0.5 * MU * (trace - 2 - 2 * np.log(J)) + 0.25 * LAM * (J**2 - 1 - 2 * np.log(J)),
    }
    for law in LAWS:
        energy = fem.respond(law, (LAM, MU), F - ONE).energy
        np.testing.assert_allclose(energy, expected[law], rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("law", LAWS)
def test_linear_limit(law):
    rng = np.random.default_rng(1)
    H = 1e-9 * rng.standard_normal((20, 2, 2))
    strain = 0.5 * (H + np.swapaxes(H, 1, 2))
    trace = np.trace(strain, axis1=1, axis2=2)
    stress = LAM * trace[:, None, None] * ONE + 2 * MU * strain
    at = fem.respond(law, (LAM, MU), H)
    np.testing.assert_allclose(at.stress, stress, rtol=0, atol=1e-7 * np.abs(stress).max())
    work = 0.5 * (stress * strain).sum(axis=(1, 2))
    np.testing.assert_allclose(at.energy, work, rtol=1e-5)


@pytest.mark.parametrize("law", LAWS)
def test_a_rotation_of_space_turns_the_stress_only(law):
    F = states()
    R = turned(170)
    one, other = (fem.respond(law, (LAM, MU), G - ONE) for G in (F, R @ F))
    np.testing.assert_allclose(other.energy, one.energy, rtol=1e-12, atol=1e-13 * E)
    # R @ F is rounded: the stress changes by the tangent times eps F, and so does F^-T in it.
    far = np.abs(F).max(axis=(1, 2), keepdims=True)
    stiffest = np.abs(one.tangent).max(axis=(1, 2, 3, 4))[:, None, None]
    error = 32.0 * np.finfo(float).eps * stiffest * far * np.linalg.cond(F)[:, None, None]
    assert (np.abs(other.stress - R @ one.stress) < error).all()
    momentum = [
        at.energy[:, None, None] * ONE - np.swapaxes(G, 1, 2) @ at.stress
        for G, at in ((F, one), (R @ F, other))
    ]
    assert (np.abs(momentum[1] - momentum[0]) < error * (1.0 + far)).all()


def test_ellipticity_of_uniaxial_stretch():
    # Hencky, plane strain, free lateral side. Along the pull the acoustic tensor is diagonal, with
    # l^2 Q_11 = lambda + 2 mu - tau and Q_22 of shear; it vanishes before the limit at stretch e.
    lengths = np.linspace(1.0, 3.5, 251)
    logs = np.log(lengths)
    lateral = np.exp(-LAM / (LAM + 2 * MU) * logs)
    H = np.zeros((len(lengths), 2, 2))
    H[:, 0, 0], H[:, 1, 1] = lengths - 1, lateral - 1
    least = fem.least_acoustic("hencky", (LAM, MU), H)
    assert least[0] == pytest.approx(MU, rel=1e-12)
    first = lengths[np.argmax(least < 0)]
    tau = E / (1 - NU**2) * np.log(first)
    assert tau < LAM + 2 * MU
    assert 3.0 < first < 3.15
    assert fem.least_acoustic("ciarlet", (LAM, MU), H).min() > 0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("element", "order"), [("T3", None), ("T6", None), ("T6", 4)])
def test_patch(element, order, law):
    """Patch test: a homogeneous deformation of the boundary, 30 % with a rotation."""
    solid = bar(element, law, order=order)
    F = turned(25) @ np.array([[1.3, 0.2], [0.1, 0.8]])
    at = rim(solid)
    loads = fem.no_loads(solid)
    for axis in range(2):
        values = (solid.nodes @ (F - ONE).T)[at, axis]
        loads = fem.hold(loads, at, axis, values)
    *_, found = fem.follow(solid, loads, [1.0], first_step=0.25)
    np.testing.assert_allclose(found.displacement, solid.nodes @ (F - ONE).T, atol=1e-12)
    P = fem.respond(law, solid.lame, F - ONE).stress
    top = end(solid, 2.0)
    inner = top[(solid.nodes[top, 0] > 0) & (solid.nodes[top, 0] < 1)]
    share = fem.traction_force(solid, lambda x: np.isclose(x[1], 2.0), (1.0, 1.0))[inner, 0]
    np.testing.assert_allclose(found.reaction[inner], share[:, None] * P[:, 1], atol=1e-11 * E)
    assert found.negative_pivots == 0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("element", ["T3", "T6"])
def test_rigid_rotation_of_a_strained_body(element, law):
    """By 170 degrees: no additional force, same energy, same J."""
    solid = bar(element, law)
    rng = np.random.default_rng(0)
    x = solid.nodes @ np.diag([0.9, 1.3]) + 0.02 * rng.standard_normal(solid.nodes.shape)
    q = rng.random(len(solid.nodes))
    R = turned(170)
    results = []
    for now in (x, x @ R.T + 7.0):
        u = now - solid.nodes
        loads = fem.Loads(np.ones_like(u, bool), u, np.zeros_like(u))
        held = fem.newton(solid, loads, 1.0, fem.Equilibrium(1.0, u, u, 0.0, (), 0, 1.0))
        results.append((held, fem.j_integral(solid, u, q)))
    (one, j_one), (other, j_other) = results
    assert other.energy == pytest.approx(one.energy, rel=1e-12)
    np.testing.assert_allclose(other.reaction, one.reaction @ R.T, rtol=0, atol=1e-12 * E)
    assert j_other == pytest.approx(j_one, rel=1e-10)


def stretched(solid):
    """The bar in tension with free sides."""
    loads = fem.hold(fem.no_loads(solid), end(solid, 0.0), 1)
    loads = fem.hold(loads, end(solid, 2.0), 1, 2.0)
    return fem.hold(loads, int(np.argmin(np.hypot(*solid.nodes.T))), 0)


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_uniaxial_stretch_of_hencky(element):
    """Closed form: lateral log strain -nu/(1-nu) that along, nominal stress E' ln(l) / l."""
    solid = bar(element, "hencky")
    loads = stretched(solid)
    *_, found = fem.follow(solid, loads, [0.5], first_step=0.1)
    modulus = E / (1 - NU**2)
    force = found.reaction[end(solid, 2.0), 1].sum()
    assert force == pytest.approx(modulus * np.log(1.5) / 1.5, rel=1e-10)
    assert found.energy == pytest.approx(2.0 * 0.5 * modulus * np.log(1.5) ** 2, rel=1e-10)
    width = np.ptp(solid.nodes[:, 0] + found.displacement[:, 0])
    assert width == pytest.approx(1.5 ** (-NU / (1 - NU)), rel=1e-10)


def test_uniaxial_stretch_of_ciarlet():
    """Closed form: tau_lateral = 0 is linear in the square of the lateral stretch."""
    solid = bar("T6", "ciarlet")
    loads = stretched(solid)
    *_, found = fem.follow(solid, loads, [0.5], first_step=0.1)
    # mu (c - 1) + lambda/2 (1.5^2 c - 1) = 0
    c = (MU + LAM / 2) / (MU + LAM / 2 * 1.5**2)
    tau = MU * (1.5**2 - 1) + LAM / 2 * (1.5**2 * c - 1)
    assert found.reaction[end(solid, 2.0), 1].sum() == pytest.approx(tau / 1.5, rel=1e-10)
    width = np.ptp(solid.nodes[:, 0] + found.displacement[:, 0])
    assert width == pytest.approx(np.sqrt(c), rel=1e-10)


def test_dead_load_ends_at_the_limit_point():
    """The limit load of an uncracked Hencky bar under dead load is E'/e, at stretch e."""
    solid = bar("T3", "hencky")
    pull = fem.traction_force(solid, lambda x: np.isclose(x[1], 2.0), (0.0, 1.0))
    assert pull[:, 1].sum() == pytest.approx(1.0, rel=1e-14)
    loads = fem.Loads(np.zeros_like(pull, bool), np.zeros_like(pull), pull)
    loads = fem.hold(loads, end(solid, 0.0), 1)
    loads = fem.hold(loads, int(np.argmin(np.hypot(*solid.nodes.T))), 0)
    limit = E / (1 - NU**2) / np.e
    with pytest.raises(fem.StabilityLostError) as lost:
        list(fem.follow(solid, loads, [2 * limit], first_step=0.1 * limit, resolution=1e-4 * limit))
    assert 0.995 * limit < lost.value.last.factor <= limit
    assert lost.value.last.stretch == pytest.approx(np.e, rel=0.06)


def test_negative_pivots_count_negative_eigenvalues():
    """A slender bar kept straight beyond its buckling loads."""
    solid = bar("T6", "neo_hookean", width=0.1, height=2.0, n=(1, 12), shake=0.0)
    loads = fem.hold(fem.no_loads(solid), end(solid, 0.0), 1)
    loads = fem.hold(loads, end(solid, 2.0), 1, -2.0)
    for height in (0.0, 2.0):
        loads = fem.hold(loads, end(solid, height), 0)
    counts = []
    for squeeze in (0.002, 0.02, 0.05):
        u = np.column_stack([np.zeros(len(solid.nodes)), -squeeze * solid.nodes[:, 1]])
        trial = equilibrium._evaluate(solid, u)
        free = ~loads.prescribed.ravel()
        matrix = trial.stiffness[free][:, free]
        _, negative = equilibrium._factor(matrix)
        assert negative == (np.linalg.eigvalsh(matrix.toarray()) < 0).sum()
        counts.append(negative)
    assert counts[0] == 0 < counts[1] < counts[2]


@pytest.mark.parametrize("law", LAWS)
def test_newton_is_quadratic(law):
    """One step of 10 %: each residual is of the order of the square of the one before."""
    plate = plate_of_5_1.edge_crack("T6", 20.0, size=100.0, growth=0.3)
    solid = fem.make_solid(plate.nodes, plate.elements, law, 210e3, 0.3)
    found = fem.newton(solid, plate_of_5_1.pulled(plate, solid), 0.1, fem.at_rest(solid))
    r = np.array(found.residuals)
    assert len(r) <= 7
    near = r[:-1] < 0.1
    assert near.sum() >= 2
    assert (r[1:][near] < 5 * r[:-1][near] ** 2 + 1e-13).all()


def test_path_independence_and_release_of_energy():
    """J of two rings agrees, also with the energy difference of a crack one element longer."""
    plate = plate_of_5_1.edge_crack("T6", 4.0, size=60.0, growth=0.3)
    solid = fem.make_solid(plate.nodes, plate.elements, "neo_hookean", 210e3, 0.3)
    loads = plate_of_5_1.pulled(plate, solid)
    found = fem.newton(solid, loads, 0.1, fem.at_rest(solid))
    rings = [
        fem.j_integral(
            solid, found.displacement, fem.ring_plateau(plate.nodes, plate.nodes[plate.tip], r)
        )
        for r in (20.0, 50.0, 90.0)
    ]
    assert np.ptp(rings) < 1e-3 * rings[0]
    # Move the tip by the very plateau, along the crack: dPi/da = -J at fixed displacement.
    q = fem.ring_plateau(plate.nodes, plate.nodes[plate.tip], 50.0)
    q[plate.elements[:, 3:]] = 0.5 * (
        q[plate.elements[:, :3]] + q[np.roll(plate.elements[:, :3], -1, axis=1)]
    )
    shift = 1e-3
    energies = []
    for sign in (1, -1):
        nodes = plate.nodes + sign * shift * np.column_stack([q, 0 * q])
        moved = fem.make_solid(nodes, plate.elements, "neo_hookean", 210e3, 0.3)
        energies.append(fem.newton(moved, loads, 0.1, found).energy)
    assert (energies[1] - energies[0]) / (2 * shift) == pytest.approx(rings[1], rel=1e-6)


def test_known_plate():
    """At 10 %, neo-Hookean: J and force by a separate total Lagrangian code, converged."""
    plate = plate_of_5_1.edge_crack("T6", 0.5, size=50.0, growth=0.3)
    solid = fem.make_solid(plate.nodes, plate.elements, "neo_hookean", 210e3, 0.3)
    loads = plate_of_5_1.pulled(plate, solid)
    found = fem.newton(solid, loads, 0.1, fem.at_rest(solid))
    assert found.negative_pivots == 0
    assert fem.j_integral(solid, found.displacement, plate.plateau) == pytest.approx(
        684_877, rel=1e-3
    )
    top = found.reaction[plate.at(1000.0), 1].sum()
    assert top == pytest.approx(1.000124e7, rel=5e-4)


def test_stored_tables(root):
    """One row of each table is computed again."""
    folder = Path(root) / "workflows/reference"

    def rows(name):
        lines = (folder / name).read_text().splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    stored = rows("large_strain_fem.csv")
    wanted = ("neo_hookean", "T3", "8.0", "0.05")
    keys = ("law", "element", "tip_size", "elongation")
    row = next(r for r in stored if tuple(r[k] for k in keys) == wanted)
    (again,) = plate_of_5_1.elongation_rows("neo_hookean", "T3", 8.0, [0.05])
    # Another mesh generator gives another grid, and another error of the grid.
    close = 1e-6 if int(row["unknowns"]) == again["unknowns"] else 0.01
    for key in ("J", "force"):
        assert float(row[key]) == pytest.approx(float(again[key]), rel=close)
    assert {r["law"] for r in stored} == set(LAWS)
    dead = rows("large_strain_dead_load.csv")
    (again,) = plate_of_5_1.traction_rows("hencky", "T3", 8.0, [10.0])
    row = next(r for r in dead if (r["element"], r["tip_size"]) == ("T3", "8.0"))
    for key in ("J", "J_linear"):
        assert float(row[key]) == pytest.approx(float(again[key]), rel=close)
