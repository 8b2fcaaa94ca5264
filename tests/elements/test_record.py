"""Element records, and the tables that follow from them."""

from __future__ import annotations

from itertools import product
from math import factorial

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import build_grid
from cfmpm.elements.record import Element, find_element
from cfmpm.fracture import cf
from cfmpm.kernels import basis
from cfmpm.registry.elements import ELEMENTS

# What follows from the order alone: its points are of no matter there.
ORDER_5 = Element(order=5, points=np.full((1, 3), 1 / 3), weights=np.ones(1), locks=False)
WHOLE = {word: find_element(word) for word in ELEMENTS}
ALL = WHOLE | {"order 5": ORDER_5}

whole = pytest.mark.parametrize("element", WHOLE.values(), ids=WHOLE)
growing = pytest.mark.parametrize(
    "element", [one for one in WHOLE.values() if one.domains is not None]
)
all_orders = pytest.mark.parametrize("element", ALL.values(), ids=ALL)


def places_in(grid, seed=0, per_triangle=5):
    """Random points in each triangle."""
    rng = np.random.default_rng(seed)
    inside = rng.dirichlet(np.ones(3), (len(grid.elements), per_triangle))
    of = np.repeat(np.arange(len(grid.elements)), per_triangle)
    return of, np.einsum("eqc,ecd->eqd", inside, grid.nodes[grid.triangles]).reshape(-1, 2)


def shoelace(polygon):
    """Signed area of a polygon in area coordinates, relative to that of the triangle."""
    x, y = (polygon / polygon.sum(axis=1, keepdims=True))[:, 1:].T
    return np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


@whole
def test_rule_integrates_the_energy_exactly(element):
    degree = 2 * (element.order - 1)
    weights = element.weights / element.weights.sum()
    np.testing.assert_allclose(element.points.sum(axis=1), 1.0, rtol=0, atol=1e-15)
    for i, j in product(range(degree + 1), repeat=2):
        if i + j <= degree:
            # int L_0^i L_1^j dA / A = 2 i! j! / (i + j + 2)!
            exact = 2 * factorial(i) * factorial(j) / factorial(i + j + 2)
            found = np.sum(weights * element.points[:, 0] ** i * element.points[:, 1] ** j)
            assert found == pytest.approx(exact, rel=1e-13)
    # Stresses are stored inside the material, and a point without volume is none.
    assert element.points.min() > 0.0
    assert weights.min() > 0.0


@growing
def test_domains_share_the_triangle_by_the_weights(element):
    areas = [shoelace(polygon) for polygon in element.domains]
    np.testing.assert_allclose(areas, element.weights / element.weights.sum(), rtol=1e-13)
    for polygon in element.domains:
        corners = polygon / polygon.sum(axis=1, keepdims=True)
        assert corners.min() > -1e-15
        turns = [shoelace(np.roll(corners, -k, axis=0)[:3]) for k in range(len(corners))]
        assert min(turns) > -1e-15  # convex
    for a, b in zip(element.points, element.domains, strict=True):
        edges = b / b.sum(axis=1, keepdims=True)
        ends = zip(edges, np.roll(edges, -1, axis=0), strict=True)
        assert all(shoelace(np.array([c, d, a])) > -1e-15 for c, d in ends)  # inside


@all_orders
def test_basis_is_one_at_its_node_and_zero_at_the_others(element):
    grid = build_grid(rectangle(3, 2, shake=0.4), element)
    k = len(element.nodes)
    of = np.repeat(np.arange(len(grid.elements)), k)
    values = grid.basis_values(of, grid.nodes[grid.elements].reshape(-1, 2))
    expected = np.tile(np.eye(k), (len(grid.elements), 1))
    np.testing.assert_allclose(values, expected, rtol=0, atol=3e-14)


@all_orders
def test_partition_of_unity_and_gradients_against_differences(element):
    grid = build_grid(rectangle(3, 3, shake=0.4), element)
    of, x = places_in(grid)
    values, gradients = grid.basis_values(of, x), grid.basis_gradients(of, x)
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(gradients.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        np.einsum("pk,pki->pi", values, grid.nodes[grid.elements[of]]), x, rtol=0, atol=1e-14
    )
    step = 1e-5
    for axis in range(2):
        ahead, behind = x.copy(), x.copy()
        ahead[:, axis] += step
        behind[:, axis] -= step
        slope = (grid.basis_values(of, ahead) - grid.basis_values(of, behind)) / (2 * step)
        scale = np.abs(gradients).max()
        np.testing.assert_allclose(gradients[:, :, axis], slope, rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("word", ["T3", "T6"])
def test_what_is_written_out_is_the_table_to_the_bit(word):
    grid = build_grid(rectangle(5, 4, shake=0.4), word)
    of, x = places_in(grid)
    element = grid.element
    table = element.nodes, element.factors, grid.nodes, grid.elements, of, x
    values = np.empty((len(of), len(element.nodes)))
    basis.lagrange_values(*table, values)
    np.testing.assert_array_equal(grid.basis_values(of, x), values)
    gradients = np.empty((len(of), len(element.nodes), 2))
    basis.lagrange_gradients(*table, gradients)
    np.testing.assert_array_equal(grid.basis_gradients(of, x), gradients)


@all_orders
def test_integrals_along_a_side(element):
    abscissae, weights = np.polynomial.legendre.leggauss(element.order + 1)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.3, 0.8]])
    for end in (0.37, 1.0):
        s = end * (0.5 + 0.5 * abscissae)
        x = np.column_stack([s, 0 * s])
        zeros = np.zeros(len(s), np.int64)
        nodes = element.nodes @ corners / element.order
        everything = np.arange(len(nodes))[None]
        on_side = basis.basis_values(element.nodes, element.factors, nodes, everything, zeros, x)[
            :, element.sides[0]
        ]
        expected = 0.5 * end * np.einsum("q,qk->k", weights, on_side)
        powers = end ** np.arange(element.order + 2)
        np.testing.assert_allclose(element.side_integrals @ powers, expected, atol=1e-15)
    np.testing.assert_allclose(element.side_weights, expected, atol=1e-15)
    # The sign of nodal forces tells closed crack faces from open ones.
    assert element.side_weights.min() > 0.0


@all_orders
def test_triangles_share_the_nodes_of_their_sides_and_crack_faces_none(element):
    p = element.order
    mesh = rectangle(6, 4, crack=(2, 0, 3), shake=0.3)
    grid = build_grid(mesh, element)
    side = np.nonzero(grid.twins.ravel() >= 0)[0]
    twin = grid.twins.ravel()[side]
    np.testing.assert_array_equal(grid.edge_nodes(side), grid.edge_nodes(twin)[:, element.turned])
    sides = (grid.twins < 0).sum() + (grid.twins >= 0).sum() // 2
    inside = (p - 1) * (p - 2) // 2
    assert len(grid.nodes) == grid.n_corners + sides * (p - 1) + len(grid.elements) * inside
    np.testing.assert_array_equal(np.unique(grid.elements), np.arange(len(grid.nodes)))
    np.testing.assert_allclose(
        grid.nodes[grid.elements],
        np.einsum("kc,ecd->ekd", element.nodes / p, grid.nodes[grid.triangles]),
        rtol=0,
        atol=1e-15,
    )
    left, right = (grid.edge_nodes(faces) for faces in grid.crack_faces["crack_1"].T)
    right = right[:, element.turned]
    np.testing.assert_allclose(grid.nodes[left], grid.nodes[right], rtol=0, atol=1e-15)
    assert set(left.ravel()) & set(right.ravel()) == {grid.tips[0].node}
    # From end to end they follow each other.
    along = grid.nodes[left[:, element.along]]
    steps = np.diff(along, axis=1)
    assert (steps[..., 0] > 0.0).all()
    np.testing.assert_allclose(steps, steps[:, :1].repeat(p, axis=1), atol=1e-15)


@all_orders
def test_linear_faces_fill_the_element(element):
    p = element.order
    corners = element.nodes[element.faces] / p
    areas = [shoelace(face) for face in corners]
    np.testing.assert_allclose(areas, 1 / p**2, rtol=1e-13)
    np.testing.assert_array_equal(np.unique(element.faces), np.arange(len(element.nodes)))


@whole
def test_faces_carry_the_strain_in_their_middle(element):
    degree = element.order - 1
    middle = element.nodes[element.faces].mean(axis=1) / element.order

    def strain(place):
        return (1.3 * place[:, 0] - 0.4 * place[:, 1] + 0.2) ** degree

    found = element.face_weights @ strain(element.points)
    np.testing.assert_allclose(found, strain(middle), rtol=0, atol=1e-13)


@all_orders
def test_weight_of_a_ring_is_linear_in_each_triangle(element):
    grid = build_grid(rectangle(8, 6, shake=0.3, crack=(3, 0, 4)), element)
    q = cf.ring_weight(grid, grid.tips[0], 0.4)
    of, x = places_in(grid)
    slopes = np.einsum("pki,pk->pi", grid.basis_gradients(of, x), q[grid.elements[of]])
    by_triangle = slopes.reshape(len(grid.elements), -1, 2)
    assert np.abs(by_triangle).max() > 2.0
    np.testing.assert_allclose(by_triangle - by_triangle[:, :1], 0.0, atol=2e-13)
