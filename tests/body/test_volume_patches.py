"""Patches: which triangles form them, and that they remove volumetric locking."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import round_off
from hooke import plane_matrix
from posed import pose, unloaded
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay
from structured import rectangle

from cfmpm.body.grid import Triangulation, build_grid
from cfmpm.body.materials import material_table
from cfmpm.body.points import seed
from cfmpm.body.volume_patches import build_patches, paired_triangles
from cfmpm.equilibrium import small_strain
from cfmpm.kernels import assembly, constitutive, patches


def scattered(n, seed):
    """A Delaunay triangulation of random points."""
    points = np.random.default_rng(seed).uniform(0, 1, (n, 2))
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    triangles[turned] = triangles[turned][:, ::-1]
    regions = np.zeros(len(triangles), np.int64)
    return Triangulation(points, triangles, regions, ("body",), {}, {}, {})


def assert_patches(grid):
    return assert_patches_of(grid, None)


def assert_patches_of(grid, paired):
    """Every triangle is in one patch; a patch is connected by sides and within one region."""
    found = build_patches(grid, paired)
    sizes = np.bincount(found.of_triangle)
    assert sizes.min() > 0
    assert len(sizes) == len(found.nodes)
    for patch, nodes in enumerate(found.nodes):
        own = np.flatnonzero(found.of_triangle == patch)
        assert set(nodes) == set(grid.elements[own].ravel())
        assert len(set(grid.regions[own])) == 1
        reached = {own[0]}
        for _ in own:
            reached |= {t // 3 for r in reached for t in grid.twins[r] if t >= 0} & set(own)
        assert reached == set(own)
    return found, sizes


@pytest.mark.parametrize("n", [3, 4, 10, 100, 500])
def test_random_triangles_are_joined_in_pairs_and_few_triples(n):
    grid = build_grid(scattered(n, n), "T3")
    _, sizes = assert_patches(grid)
    if n > 3:
        assert sizes.min() == 2
    assert np.count_nonzero(sizes > 2) <= max(1, 0.1 * len(sizes))


def test_no_patch_across_a_crack_or_the_border_of_a_region():
    mesh = rectangle(8, 6, shake=0.4, crack=(3, 0, 5))
    mesh = replace(mesh, regions=(mesh.nodes[mesh.triangles].mean(axis=1)[:, 0] > 0.6).astype(int))
    grid = build_grid(mesh, "T3")
    found, sizes = assert_patches(grid)
    assert sizes.min() == 2
    above = grid.nodes[grid.triangles].mean(axis=1)[:, 1] > 0.5
    beside = (grid.nodes[grid.triangles].max(axis=1)[:, 0] <= 5 / 8 + 1e-9) & (grid.regions == 0)
    upper = found.of_triangle[above & beside]
    assert not np.isin(upper, found.of_triangle[~above & beside]).any()


def test_a_triangle_without_neighbours_stays_alone():
    mesh = rectangle(2, 1)
    grid = build_grid(replace(mesh, regions=np.array([0, 1, 2, 2])), "T3")
    # Which two meet depends on the diagonals; nobody may cross a region.
    assert_patches(grid)
    lone = build_grid(replace(mesh, regions=np.arange(4)), "T3")
    assert build_patches(lone).of_triangle.tolist() == [0, 1, 2, 3]
    np.testing.assert_array_equal(build_patches(lone).nodes, np.sort(lone.elements))


def partition(patch, triangles):
    """The patches that lie within some triangles, as sets."""
    found = {frozenset(np.flatnonzero(patch == k).tolist()) for k in np.unique(patch)}
    return {own for own in found if own <= set(triangles.tolist())}


def test_patches_stay_as_a_crack_grows():
    """Only those change that are cut, and those beside, which take what is left over."""
    anew = 0
    for number in range(5):
        grid = build_grid(scattered(300, number), "T3")
        centre = grid.nodes[grid.triangles].mean(axis=1)
        away = np.hypot(*(centre - 0.5).T)
        before = paired_triangles(grid)
        # The side between the two triangles of a patch in the middle is cut.
        middle = np.argsort(away)
        t, k = next(
            (t, k)
            for t in middle
            for k in range(3)
            if grid.twins[t, k] >= 0 and before[grid.twins[t, k] // 3] == before[t]
        )
        twins = grid.twins.copy()
        twins.flat[twins[t, k]] = -1
        twins[t, k] = -1
        cut = replace(grid, twins=twins)
        kept = paired_triangles(cut, before)
        assert_patches_of(cut, kept)
        far = np.flatnonzero(away > 0.2)
        assert partition(before, far) == partition(kept, far)
        anew += partition(before, far) != partition(paired_triangles(cut), far)
        # Where nothing can be kept they are made anew; and then nothing is left to change.
        nothing = np.arange(len(kept))
        np.testing.assert_array_equal(paired_triangles(cut, nothing), paired_triangles(cut))
        np.testing.assert_array_equal(paired_triangles(cut, kept), kept)
    assert anew


def test_split_triangles_find_a_patch():
    """New triangles are appended; those before keep their numbers."""
    grid = build_grid(rectangle(6, 6, shake=0.3), "T3")
    some = np.arange(50)
    kept = paired_triangles(grid, paired_triangles(grid)[some])
    assert_patches_of(grid, kept)
    assert kept.max() + 1 >= len(grid.triangles) // 3


def test_t6_averages_over_each_triangle():
    grid = build_grid(rectangle(2, 2), "T6")
    found = build_patches(grid)
    np.testing.assert_array_equal(found.of_triangle, np.arange(8))
    np.testing.assert_array_equal(found.nodes, grid.elements)


def radial_displacement(element, nu, *, patched, n=12, pressure=1.0, inner=1.0, outer=2.0):
    """Mean radial displacement of the bore of a quarter tube under pressure, relative to Lame's."""
    mesh = rectangle(n, n, shake=0.3, seed=2)
    grid = build_grid(mesh, element)
    r = inner + (outer - inner) * grid.nodes[:, 0]
    angle = 0.5 * np.pi * grid.nodes[:, 1]
    grid = replace(grid, nodes=np.column_stack([r * np.cos(angle), r * np.sin(angle)]))
    if element == "T6":
        for k in range(3):
            ends = grid.nodes[grid.elements[:, k]] + grid.nodes[grid.elements[:, (k + 1) % 3]]
            grid.nodes[grid.elements[:, 3 + k]] = 0.5 * ends
    points = seed(grid)
    gradients = grid.basis_gradients(points.element, points.position)
    free = np.ones((len(grid.nodes), 2), bool)
    free[np.unique(grid.edges["bottom"]), 1] = False
    free[np.unique(grid.edges["top"]), 0] = False
    number = np.where(free, (np.cumsum(free) - 1).reshape(free.shape), -1)

    force = np.zeros(free.shape)
    for edge in grid.edges["left"]:
        along = grid.nodes[edge[1]] - grid.nodes[edge[0]]
        # The body lies to the left of the edge, the bore to its right.
        load = pressure * np.array([-along[1], along[0]])
        weights = [0.5, 0.5] if element == "T3" else [1 / 6, 1 / 6, 2 / 3]
        force[edge] += np.outer(weights, load)

    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    shared = points.element, gradients, points.volume, points.material
    if patched:
        joined = build_patches(grid)
        indptr, indices = assembly.sparsity(joined.nodes, number)
        data = assembly.stiffness(
            grid.elements, number, indptr, indices, *shared, plane_matrix(0.0, mu)
        )
        data += patches.coupling(
            assembly.entry_slots(joined.nodes, number, indptr, indices),
            len(indices),
            joined.nodes,
            grid.elements,
            *shared[:3],
            np.full(len(joined.nodes), lam),
            np.zeros((len(points), 2, 2)),
            joined.of_triangle[points.element],
        )
    else:
        indptr, indices = assembly.sparsity(grid.elements, number)
        data = assembly.stiffness(
            grid.elements, number, indptr, indices, *shared, plane_matrix(lam, mu)
        )
    u = np.zeros(free.shape)
    u[free] = splu(csc_array((data, indices, indptr))).solve(force[free])

    H, _, energy = constitutive.linear_elastic(
        grid.elements, points.element, gradients, points.material, plane_matrix(0.0, mu), u
    )
    if patched:
        energy = (
            energy
            + patches.mean_pressure(
                points.volume,
                points.material,
                np.array([lam]),
                H,
                joined.of_triangle[points.element],
            )[1]
        )
        stored = np.sum(energy * points.volume)
        # Stored and supplied are the same sum, taken in two ways: near incompressibility its terms
        # are 1e9 times as large as what is left of them.
        body = round_off.LinearBody(grid, points, gradients, u, round_off.stiffest(1.0, nu))
        np.testing.assert_allclose(stored, 0.5 * np.sum(force * u), rtol=0, atol=body.of_energy)
    bore = np.unique(grid.edges["left"])
    x = grid.nodes[bore]
    radial = np.mean(np.sum(u[bore] * x, axis=1) / np.hypot(*x.T))
    factor = (1 + nu) * pressure * inner**2 / (outer**2 - inner**2)
    return radial / (factor * ((1 - 2 * nu) * inner + outer**2 / inner))


@pytest.mark.parametrize(("element", "bound"), [("T3", 0.01), ("T6", 0.002)])
def test_no_locking(element, bound):
    """Tube under internal pressure (Lame): near incompressibility the error is that at nu = 0.3."""
    for nu in (0.3, 0.499, 0.4999, 0.499999):
        error = radial_displacement(element, nu, patched=True) - 1.0
        assert abs(error) < bound, (nu, error)
    finer = radial_displacement(element, 0.499999, patched=True, n=24) - 1.0
    # Second order.
    assert abs(finer) < 0.3 * abs(error)


def test_without_patches_t3_locks():
    assert radial_displacement("T3", 0.499999, patched=False) < 0.8


def test_a_piece_of_round_off_size_in_another_material_does_not_change_the_stiffness():
    """A particle domain may have such a part beyond an interface, as the last point of a patch."""
    grid = build_grid(rectangle(4, 4, 4.0, 4.0, shake=0.3), "T3")
    points = seed(grid)
    piece = {field.name: getattr(points, field.name)[[5]] for field in fields(points)}
    piece |= {"volume": np.array([1e-17]), "material": np.array([1])}
    points = type(points)(
        **{name: np.concatenate([getattr(points, name), one]) for name, one in piece.items()}
    )
    rows = [{"E": 1e3, "nu": 0.49}, {"E": 1e4, "nu": 0.2}]
    problem = pose(
        grid, unloaded(grid), material_table(rows, "strain"), points, patches=build_patches(grid)
    )
    u = np.random.default_rng(0).normal(size=grid.nodes.shape)
    force = small_strain.internal_force(problem, small_strain.deform(problem, u))
    found = (small_strain.assemble_stiffness(problem) @ u.ravel()).reshape(-1, 2)
    np.testing.assert_allclose(found, force, rtol=0, atol=1e-12 * np.abs(force).max())
