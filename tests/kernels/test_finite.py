"""Kernels of finite deformation: derivatives of the energy, rotation, reset, small strain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hooke import plane_matrix
from scipy.sparse import csr_array
from structured import rectangle

from cfmpm.body.grid import Grid, build_grid
from cfmpm.body.points import MaterialPoints, seed
from cfmpm.body.volume_patches import build_patches
from cfmpm.kernels import assembly, constitutive, eshelby, finite, patches
from cfmpm.kernels.laws import dispatch
from cfmpm.registry.laws import LAWS as TABLE

PARAMETERS = np.array([[1.2e5, 8e4, 300.0, 1e3], [6e4, 3e4, 100.0, 0.0]])
# All that are known with the constants above.
LAWS = [word for word, law in TABLE.items() if not law.constants or word == "j2"]
ALONE = np.zeros(0, np.int64)
ANGLE = np.deg2rad(170.0)
ROTATION = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])


@dataclass
class Body:
    """A grid with points, of two materials; `macro` are the elements of the stiffness."""

    grid: Grid
    points: MaterialPoints
    law: np.ndarray
    base: np.ndarray
    internal: np.ndarray
    gradients: np.ndarray
    patch: np.ndarray
    macro: np.ndarray

    @property
    def n(self):
        return len(self.grid.nodes)

    def update(self, u):
        points = self.points
        return finite.update_points(
            self.grid.elements,
            points.element,
            self.gradients,
            self.base,
            points.volume,
            points.material,
            self.law,
            PARAMETERS,
            self.internal,
            np.ascontiguousarray(u),
            self.patch,
        )

    def energy(self, u):
        """Stored energy with the plastic work of the step."""
        _, _, energy, internal, _ = self.update(u)
        work = internal[:, 5] if internal.shape[1] else 0.0
        return np.sum((energy + work) * self.points.volume)

    def force(self, u):
        H, stress, *_ = self.update(u)
        return finite.internal_force(*self.where, H, stress)

    def configurational_force(self, u):
        H, stress, energy, internal, _ = self.update(u)
        work = internal[:, 5] if internal.shape[1] else 0.0
        return finite.configurational_force(*self.where, H, stress, energy + work)

    @property
    def where(self):
        points = self.points
        return self.grid.elements, self.n, points.element, self.gradients, points.volume

    def bulk(self, H):
        points = self.points
        return patches.bulk_moduli(
            len(self.macro), points.volume, points.material, self.law, PARAMETERS, H, self.patch
        )

    def stiffness(self, u, free=None):
        if free is None:
            free = np.arange(2 * self.n).reshape(-1, 2)
        indptr, indices = assembly.sparsity(self.macro, free)
        points, H = self.points, self.update(u)[0]
        shared = points.element, self.gradients, points.volume, points.material
        shared += self.law, PARAMETERS
        slots = assembly.entry_slots(self.grid.elements, free, indptr, indices)
        data = finite.stiffness(slots, len(indices), *shared, self.internal, H, self.patch)
        if len(self.patch):
            slots = assembly.entry_slots(self.macro, free, indptr, indices)
            data += patches.coupling(
                slots,
                len(indices),
                self.macro,
                self.grid.elements,
                *shared[:3],
                self.bulk(H),
                H,
                self.patch,
            )
        return csr_array((data, indices, indptr)).toarray()


def body(law, element="T3", *, patched=False):
    grid = build_grid(rectangle(4, 3, 4.0, 3.0, shake=0.4, seed=1), element)
    grid = replace(grid, regions=np.arange(len(grid.elements)) // 10)
    points = seed(grid)
    points = replace(points, material=points.material % 2)
    joined = build_patches(grid)
    return Body(
        grid,
        points,
        np.array([dispatch.NUMBERS[law]] * 2),
        np.zeros((len(points), 2, 2)),
        np.zeros((len(points), 6 if law == "j2" else 0)),
        grid.basis_gradients(points.element, points.position),
        joined.of_triangle[points.element] if patched else ALONE,
        joined.nodes if patched else grid.elements,
    )


def moved_to(model, nodes):
    """The same points in the triangles of a grid with other nodes."""
    grid = replace(model.grid, nodes=nodes)
    points = replace(seed(grid), material=model.points.material)
    gradients = grid.basis_gradients(points.element, points.position)
    return replace(model, grid=grid, points=points, gradients=gradients)


def displacement(grid, size, seed=0):
    """A field with about 30 % stretch and shear, and noise, multiplied by `size`."""
    noise = np.random.default_rng(seed).uniform(-0.08, 0.08, grid.nodes.shape)
    return size * (grid.nodes @ np.array([[0.3, 0.2], [-0.1, -0.1]]) + noise)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("patched", [False, True])
def test_force_and_stiffness_are_derivatives_of_the_energy(law, element, patched):
    model = body(law, element, patched=patched)
    u = displacement(model.grid, 1.0)
    if law == "j2":
        # From a plastic state.
        model.internal = model.update(0.5 * u)[3]
    force, K = model.force(u), model.stiffness(u)
    rng = np.random.default_rng(3)
    for _ in range(5):
        d = rng.uniform(-1, 1, u.shape)
        values = [(model.energy(u + h * d), model.force(u + h * d)) for h in (-1e-5, 1e-5)]
        slope = (values[1][0] - values[0][0]) / 2e-5
        np.testing.assert_allclose(np.sum(force * d), slope, atol=1e-8 * abs(force * d).sum())
        change = (values[1][1] - values[0][1]) / 2e-5
        product = (K @ d.ravel()).reshape(-1, 2)
        np.testing.assert_allclose(product, change, atol=1e-8 * abs(change).max())
    np.testing.assert_array_equal(K, K.T)
    # A translation does nothing, a rotation turns the forces.
    scale = 1e-12 * abs(K).max()
    np.testing.assert_allclose(K @ np.tile([1.0, 0.0], model.n), 0.0, atol=scale)
    x = model.grid.nodes + u
    spin = np.column_stack([-x[:, 1], x[:, 0]])
    turned = np.column_stack([-force[:, 1], force[:, 0]])
    np.testing.assert_allclose((K @ spin.ravel()).reshape(-1, 2), turned, atol=100 * scale)


def test_prescribed_degrees_of_freedom_are_left_out():
    model = body("hencky", "T6")
    u = displacement(model.grid, 1.0)
    free = np.full(2 * model.n, -1)
    kept = np.sort(np.random.default_rng(0).permutation(2 * model.n)[: model.n])
    free[kept] = np.arange(len(kept))
    part = model.stiffness(u, free.reshape(-1, 2))
    np.testing.assert_array_equal(part, model.stiffness(u)[np.ix_(kept, kept)])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("patched", [False, True])
def test_configurational_force_is_the_derivative_by_the_reference_position(law, element, patched):
    """CF_I = - d E / d X_I with the displacement of the nodes held."""
    model = body(law, element, patched=patched)
    nodes = model.grid.nodes
    u = displacement(model.grid, 1.0)
    reference = model.configurational_force(u)
    corners = model.grid.n_corners

    def energy(moved):
        # Middle nodes stay in the middle: their shape functions move with the corners.
        nodes_now = nodes.copy()
        nodes_now[:corners] = moved
        for e in model.grid.elements if element == "T6" else []:
            nodes_now[e[3:]] = 0.5 * (nodes_now[e[:3]] + nodes_now[np.roll(e[:3], -1)])
        return moved_to(model, nodes_now).energy(u)

    expected = np.zeros((corners, 2))
    for i, j in np.ndindex(corners, 2):
        d = np.zeros((corners, 2))
        d[i, j] = 1e-5
        expected[i, j] = (energy(nodes[:corners] - d) - energy(nodes[:corners] + d)) / 2e-5
    ours = reference[:corners].copy()
    if element == "T6":
        sides = np.vstack([model.grid.elements[:, [k, (k + 1) % 3, 3 + k]] for k in range(3)])
        sides[:, :2].sort(axis=1)
        for a, b, middle in np.unique(sides, axis=0):
            ours[[a, b]] += 0.5 * reference[middle]
    np.testing.assert_allclose(ours, expected, atol=1e-8 * abs(expected).max())


@pytest.mark.parametrize("law", LAWS)
def test_a_rotation_of_170_degrees_changes_nothing_but_the_direction_of_stress(law):
    model = body(law)
    u = displacement(model.grid, 1.0)
    turned_u = (model.grid.nodes + u) @ ROTATION.T - model.grid.nodes
    _, stress, energy, internal, det_F = model.update(u)
    _, turned_stress, same_energy, same_internal, same_det = model.update(turned_u)
    scale = 1e-10 * abs(stress).max()
    np.testing.assert_allclose(same_energy, energy, atol=scale)
    np.testing.assert_allclose(same_det, det_F, rtol=1e-10)
    np.testing.assert_allclose(same_internal, internal, atol=1e-10)
    full = np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=1)
    expected = ROTATION @ full @ ROTATION.T
    full = np.stack([turned_stress[:, [0, 2]], turned_stress[:, [2, 1]]], axis=1)
    np.testing.assert_allclose(full, expected, atol=scale)
    f = model.force(u)
    np.testing.assert_allclose(model.force(turned_u), f @ ROTATION.T, atol=10 * scale)
    # With H for F the sum holds the internal force besides, which is zero in balance.
    np.testing.assert_allclose(
        model.configurational_force(turned_u) + model.force(turned_u),
        model.configurational_force(u) + f,
        atol=10 * scale,
    )


def test_sum_of_the_eshelby_stress_is_the_configurational_force():
    """Sigma = W I - F^T P, with P and F from the stress and the displacement gradient."""
    model = body("ciarlet", "T6")
    u = displacement(model.grid, 1.0)
    H, stress, energy, *_ = model.update(u)
    F = np.eye(2) + H
    P = np.linalg.det(F)[:, None, None] * np.einsum(
        "pij,pkj->pik", stress[:, [[0, 2], [2, 1]]], np.linalg.inv(F)
    )
    Sigma = energy[:, None, None] * np.eye(2) - np.einsum("pji,pjk->pik", F, P)
    # Isotropy in the virgin state: F^T P = C S with S a function of C (Maugin 1993, ch. 4).
    CS = np.einsum("pki,pkj,pjl->pil", F, F, np.einsum("pij,pjk->pik", np.linalg.inv(F), P))
    np.testing.assert_allclose(CS, np.einsum("pji,pjk->pik", F, P), atol=1e-9 * abs(CS).max())
    summed = np.zeros((model.n, 2))
    nodal = -np.einsum("pij,paj,p->pai", Sigma, model.gradients, model.points.volume)
    np.add.at(summed, model.grid.elements[model.points.element], nodal)
    ours = model.configurational_force(u) + model.force(u)
    np.testing.assert_allclose(ours, summed, atol=1e-11 * abs(summed).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("element", ["T3", "T6"])
def test_reset_grid_gives_what_one_step_from_the_reference_gives(law, element):
    """F = (I + grad du) F_n with G = F_n^T dS/dx on the grid carried along to state n."""
    total = body(law, element)
    half, u = displacement(total.grid, 0.6), displacement(total.grid, 1.0, seed=1)
    base, _, _, internal, _ = total.update(half)
    if law == "j2":
        total.internal = internal
    # T6 gradients in space follow from the Jacobian of the map, whatever shape the sides take.
    in_space = np.einsum("paj,pji->pai", total.gradients, np.linalg.inv(np.eye(2) + base))
    if element == "T3":
        moved = total.grid.nodes + half
        carried = moved[total.grid.elements].mean(axis=1)
        np.testing.assert_allclose(
            replace(total.grid, nodes=moved).basis_gradients(total.points.element, carried),
            in_space,
            atol=1e-12 * abs(in_space).max(),
        )
    pulled = np.einsum("paj,pji->pai", in_space, np.eye(2) + base)
    updated = replace(total, base=base, gradients=pulled)
    for ours, reference in zip(updated.update(u - half), total.update(u), strict=True):
        scale = max(abs(reference).max(initial=0), 1.0)
        np.testing.assert_allclose(ours, reference, atol=1e-12 * scale)
    for name in ("force", "configurational_force", "stiffness"):
        ours, reference = getattr(updated, name)(u - half), getattr(total, name)(u)
        np.testing.assert_allclose(ours, reference, atol=1e-12 * abs(reference).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("size", [1e-13, 1e-9, 1e-6])
def test_small_strain_limit(law, size):
    """The same as the linear kernels, up to terms of the next order."""
    model = body(law, "T6")
    u = displacement(model.grid, size)
    points, elements = model.points, model.grid.elements
    elastic = plane_matrix(*PARAMETERS[:, :2].T)
    linear = constitutive.linear_elastic(
        elements, points.element, model.gradients, points.material, elastic, u
    )
    near = 1e-12 + 20 * size
    for ours, reference in zip(model.update(u), linear, strict=False):
        np.testing.assert_allclose(ours, reference, atol=near * abs(reference).max())
    force = assembly.internal_force(*model.where, linear[1])
    np.testing.assert_allclose(model.force(u), force, atol=near * abs(force).max())
    cf = eshelby.configurational_force(*model.where, *linear)
    np.testing.assert_allclose(model.configurational_force(u), cf, atol=near * abs(cf).max())
    free = np.arange(2 * model.n).reshape(-1, 2)
    indptr, indices = assembly.sparsity(elements, free)
    data = assembly.stiffness(
        elements,
        free,
        indptr,
        indices,
        points.element,
        model.gradients,
        points.volume,
        points.material,
        elastic,
    )
    K = csr_array((data, indices, indptr)).toarray()
    np.testing.assert_allclose(model.stiffness(u), K, atol=near * abs(K).max())


@pytest.mark.parametrize("law", LAWS)
def test_an_inverted_point_is_marked_and_no_other_touched(law):
    model = body(law)
    u = displacement(model.grid, 0.1)
    sound = model.update(u)
    triangle = model.grid.triangles[0]
    x = model.grid.nodes[triangle] + u[triangle]
    # One corner goes through the opposite side.
    u[triangle[0]] += 2.2 * (0.5 * (x[1] + x[2]) - x[0])
    H, stress, energy, internal, det_F = model.update(u)
    inverted = det_F <= 0
    untouched = ~(model.grid.triangles == triangle[0]).any(axis=1)[model.points.element]
    assert inverted[0]
    assert untouched.any()
    assert np.isfinite(H).all()
    assert np.isnan(stress[inverted]).all()
    assert np.isposinf(energy[inverted]).all()
    np.testing.assert_array_equal(internal[inverted], model.internal[inverted])
    assert np.isfinite(stress[~inverted]).all()
    assert np.isfinite(energy[~inverted]).all()
    for now, before in zip((H, stress, energy, internal, det_F), sound, strict=True):
        np.testing.assert_array_equal(now[untouched], before[untouched])


def test_force_of_the_plastic_work():
    """-sum W_p dS/dX V, by the same kernel without stress."""
    model = body("j2")
    H, stress, energy, internal, _ = model.update(displacement(model.grid, 1.0))
    work = internal[:, 5].copy()
    assert work.min() > 0
    both = finite.configurational_force(*model.where, H, stress, energy + work)
    stored = finite.configurational_force(*model.where, H, stress, energy)
    dissipated = finite.configurational_force(*model.where, H, np.zeros_like(stress), work)
    np.testing.assert_allclose(both, stored + dissipated, atol=1e-12 * abs(both).max())


def test_elastic_points_beside_plastic_ones():
    """Each point responds as if alone; elastic points have no internal variables."""
    model = body("j2", "T6")
    u = displacement(model.grid, 1.0)
    plastic, elastic = model.update(u), body("hencky", "T6").update(u)
    model.law = np.array([dispatch.NUMBERS[word] for word in ("j2", "hencky")])
    second = model.points.material == 1
    for k, ours in enumerate(model.update(u)):
        np.testing.assert_array_equal(ours[~second], plastic[k][~second])
        if k != 3:
            np.testing.assert_array_equal(ours[second], elastic[k][second])
    assert not model.update(u)[3][second].any()


@pytest.mark.parametrize("law", LAWS)
def test_patches_do_nothing_to_a_uniform_field(law):
    alone, patched = body(law), body(law, patched=True)
    u = alone.grid.nodes @ np.array([[0.3, 0.2], [-0.1, -0.1]])
    for ours, reference in zip(patched.update(u), alone.update(u), strict=True):
        scale = abs(reference).max(initial=0)
        np.testing.assert_allclose(ours, reference, atol=1e-12 * scale)
    np.testing.assert_allclose(patched.force(u), alone.force(u), atol=1e-12 * PARAMETERS.max())


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_patches_at_small_strain_are_the_limit(element):
    model = body("hencky", element, patched=True)
    size = 1e-9
    near = 1e-12 + 20 * size
    u = displacement(model.grid, size)
    points, elements = model.points, model.grid.elements
    lam, mu = PARAMETERS[:, :2].T
    without = plane_matrix(0.0 * lam, mu)
    H, stress, energy = constitutive.linear_elastic(
        elements, points.element, model.gradients, points.material, without, u
    )
    pressure, stored = patches.mean_pressure(points.volume, points.material, lam, H, model.patch)
    stress[:, :2] += pressure[:, None]
    _, ours, our_energy, *_ = model.update(u)
    np.testing.assert_allclose(ours, stress, atol=near * abs(stress).max())
    np.testing.assert_allclose(our_energy, energy + stored, atol=near * abs(energy).max())
    free = np.arange(2 * model.n).reshape(-1, 2)
    indptr, indices = assembly.sparsity(model.macro, free)
    shared = points.element, model.gradients, points.volume, points.material
    data = assembly.stiffness(elements, free, indptr, indices, *shared, without)
    data += patches.coupling(
        assembly.entry_slots(model.macro, free, indptr, indices),
        len(indices),
        model.macro,
        elements,
        *shared[:3],
        model.bulk(np.zeros_like(H)),
        np.zeros_like(H),
        model.patch,
    )
    K = csr_array((data, indices, indptr)).toarray()
    np.testing.assert_allclose(model.stiffness(u), K, atol=near * abs(K).max())
    # Linear: force is stiffness times displacement, and half their product the energy.
    force = assembly.internal_force(*model.where, stress)
    np.testing.assert_allclose((K @ u.ravel()).reshape(-1, 2), force, atol=1e-12 * abs(force).max())
    total = np.sum((energy + stored) * points.volume)
    np.testing.assert_allclose(0.5 * np.sum(force * u), total, rtol=1e-11)
