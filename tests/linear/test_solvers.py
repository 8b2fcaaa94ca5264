from __future__ import annotations

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import block_diag, coo_array, csr_array
from structured import rectangle

from cfmpm.errors import SolveError
from cfmpm.linear import amg, solvers
from cfmpm.linear.engine import NotPositiveDefiniteError
from cfmpm.linear.solvers import rigid_body_modes, select
from cfmpm.registry.solvers import SOLVERS

MODULUS, POISSON = 210e3, 0.3  # N/mm^2
DIRECT = ("cholmod", "rslab", "superlu")


@pytest.fixture(params=SOLVERS)
def solver(request):
    if not solvers.available(request.param):
        pytest.skip(f"{request.param} is not installed")
    return select(1, request.param)


def stiffness(x, triangles, modulus=MODULUS):
    """Plane strain, T3, one modulus or one for each triangle; no support."""
    lame, shear = POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), 1 / (2 * (1 + POISSON))
    D = np.diag([lame + 2 * shear, lame + 2 * shear, shear])
    D[0, 1] = D[1, 0] = lame
    m = len(triangles)
    corners = x[triangles]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    gradients = np.array([[-1.0, -1], [1, 0], [0, 1]]) @ np.linalg.inv(edges)
    B = np.zeros((m, 3, 3, 2))
    B[:, 0, :, 0] = B[:, 2, :, 1] = gradients[:, :, 0]
    B[:, 1, :, 1] = B[:, 2, :, 0] = gradients[:, :, 1]
    B = B.reshape(m, 3, 6)
    weight = np.broadcast_to(modulus, m) * np.linalg.det(edges) / 2
    entries = np.einsum("m,mki,kl,mlj->mij", weight, B, D, B)
    dofs = (2 * triangles[:, :, None] + [0, 1]).reshape(m, 6)
    rows, columns = np.repeat(dofs, 6, 1), np.tile(dofs, 6)
    size = 2 * len(x)
    return coo_array((entries.ravel(), (rows.ravel(), columns.ravel())), (size, size)).tocsr()


def plate(nx=12, ny=9, seed=0, modulus=MODULUS):
    """A block held at its bottom: matrix of the free unknowns and the rigid body modes."""
    grid = rectangle(nx, ny, 10.0 * nx, 10.0 * ny, shake=0.4, seed=seed)
    free = np.repeat(grid.nodes[:, 1] > 0.0, 2)
    K = stiffness(grid.nodes, grid.triangles, modulus)
    return csr_array(K[free][:, free]), rigid_body_modes(grid.nodes, free)


def floating(nx=9, ny=7):
    """A block without support."""
    grid = rectangle(nx, ny, 10.0 * nx, 10.0 * ny, shake=0.4)
    everything = np.ones(grid.nodes.shape, bool)
    return stiffness(grid.nodes, grid.triangles), rigid_body_modes(grid.nodes, everything)


def detached():
    """A supported block beside a floating one."""
    (K, modes), (other, other_modes) = plate(), floating()
    return csr_array(block_diag([K, other], format="csr")), np.vstack([modes, other_modes])


def hinged():
    """A supported block that carries another one at a single node."""
    lower, upper = rectangle(8, 6, 80.0, 60.0, shake=0.4), rectangle(7, 5, 70.0, 50.0, shake=0.4)
    x = np.vstack([lower.nodes, upper.nodes + np.array([80.0, 60.0])])
    shared = len(lower.nodes) - 1
    np.testing.assert_array_equal(x[shared], x[shared + 1])
    triangles = np.vstack([lower.triangles, upper.triangles + len(lower.nodes)])
    triangles = triangles - (triangles > shared)
    x = np.delete(x, shared + 1, axis=0)
    free = np.repeat(x[:, 1] > 0.0, 2)
    K = stiffness(x, triangles)
    return csr_array(K[free][:, free]), rigid_body_modes(x, free)


def softened(K, shift=0.01):
    """The same pattern with some negative eigenvalues and a positive diagonal."""
    K = K.copy()
    rows = np.repeat(np.arange(K.shape[0]), np.diff(K.indptr))
    K.data[K.indices == rows] -= shift * K.diagonal().max()
    assert (K.diagonal() > 0.0).all()
    return K


def backward_error(K, x, b):
    scale = abs(K).max() * np.linalg.norm(x) + np.linalg.norm(b)
    return np.linalg.norm(b - K @ x) / scale


def test_modes_are_annihilated():
    K, modes = floating()
    np.testing.assert_allclose(K @ modes, 0.0, atol=1e-12 * abs(K).max())


def test_modes_of_the_free_unknowns():
    x = np.array([[0.0, 0.0], [2.0, 0.0]])
    free = np.array([[True, False], [True, True]])
    expected = [[1, 0, 0], [1, 0, 0], [0, 1, 1]]
    np.testing.assert_array_equal(rigid_body_modes(x, free), expected)
    np.testing.assert_array_equal(rigid_body_modes(x, free.ravel()), expected)
    assert rigid_body_modes(np.zeros((0, 2)), np.zeros(0, bool)).shape == (0, 3)


@pytest.mark.parametrize("name", SOLVERS)
@settings(max_examples=15)
@given(nx=st.integers(1, 25), ny=st.integers(1, 25), seed=st.integers(0, 99))
def test_solves(name, nx, ny, seed):
    if not solvers.available(name):
        pytest.skip(f"{name} is not installed")
    K, modes = plate(nx, ny, seed)
    exact = np.random.default_rng(seed).standard_normal(K.shape[0])
    b = K @ exact
    factor = select(K.shape[0], name).factor(K, modes)
    solution = factor.solve(b)
    if name in DIRECT:
        assert backward_error(K, solution.x, b) < 1e-14
        np.testing.assert_allclose(solution.x, exact, atol=1e-10)
        assert solution.iterations == 0
    else:
        assert np.linalg.norm(b - K @ solution.x) < 1e-9 * np.linalg.norm(b)
        np.testing.assert_allclose(solution.x, exact, atol=1e-6)
        assert 0 < solution.iterations < 40


def test_contrast_of_stiffness(solver):
    # A soft layer carries a block a million times stiffer: sound, though badly scaled.
    modulus = np.full(2 * 12 * 9, MODULUS)
    modulus[:40] *= 1e-6
    K, modes = plate(modulus=modulus)
    b = np.ones(K.shape[0])
    solution = solver.factor(K, modes).solve(b)
    assert backward_error(K, solution.x, b) < 1e-12


def test_refactor_gives_the_bits_of_a_fresh_factor(solver):
    K, modes = plate()
    other, _ = plate(modulus=np.linspace(1.0, 3.0, 2 * 12 * 9))
    b = np.linspace(-1.0, 1.0, K.shape[0])
    factor = solver.factor(K, modes)
    factor.refactor(other)
    np.testing.assert_array_equal(factor.solve(b).x, solver.factor(other, modes).solve(b).x)
    factor.refactor(K)
    np.testing.assert_array_equal(factor.solve(b).x, solver.factor(K, modes).solve(b).x)


def test_refactor_refuses_another_pattern(solver):
    K, modes = plate()
    factor = solver.factor(K, modes)
    with pytest.raises(ValueError, match="pattern"):
        factor.refactor(csr_array(np.diag(K.diagonal())))


def test_argument_is_left_alone(solver):
    K, modes = plate()
    before, b = K.copy(), np.ones(K.shape[0])
    solver.factor(K, modes).solve(b)
    np.testing.assert_array_equal(K.toarray(), before.toarray())
    np.testing.assert_array_equal(b, 1.0)


def test_indefinite(solver):
    K, modes = plate()
    bad = softened(K)
    negative = np.count_nonzero(np.linalg.eigvalsh(bad.toarray()) < 0.0)
    assert negative > 0
    with pytest.raises(NotPositiveDefiniteError, match="stability") as caught:
        solver.factor(bad, modes)
    if solver.name in ("rslab", "superlu"):
        assert caught.value.seen.startswith(f"{negative} pivots are negative")


def test_an_unstable_part_is_told_where_it_is(solver):
    """The place does not depend on the order of elimination."""
    (K, modes), first = plate(), 50
    pair = K.diagonal().max() * np.array([[1.0, 2.0], [2.0, 1.0]])
    bad = csr_array(block_diag([K[:first, :first], pair, K[first:, first:]], format="csr"))
    modes = np.insert(modes, [first, first], 1.0, axis=0)
    with pytest.raises(NotPositiveDefiniteError) as caught:
        solver.factor(bad, modes)
    said = re.search(r"unknown (\d+)", caught.value.seen)
    assert said is None or int(said[1]) in {first, first + 1}
    assert said is not None or solver.name != "superlu"


def test_good_matrix_after_a_bad_one(solver):
    K, modes = plate()
    b = np.ones(K.shape[0])
    factor = solver.factor(K, modes)
    x = factor.solve(b).x
    for _ in range(2):
        with pytest.raises(NotPositiveDefiniteError):
            factor.refactor(softened(K))
        factor.refactor(K)
        np.testing.assert_array_equal(factor.solve(b).x, x)


@pytest.mark.parametrize("mechanism", [floating, detached, hinged])
def test_singular(solver, mechanism):
    K, modes = mechanism()
    with pytest.raises(NotPositiveDefiniteError, match="mechanism"):
        solver.factor(K, modes)


def pairs_on_weak_ground(growth, weak=range(20)):
    """Twenty pairs of coupled nodes; on pairs with a weak support a probe grows by this factor.

    Elimination is exact in binary, in any order: all pivots are positive, and no solver sees
    anything but the size of the answer. To two like signs it is 2 over the ground, to unlike ones
    of the size of one.
    """
    pairs = [
        np.array([[1.0, -1.0], [-1.0, 1.0 + (2.0 / growth if i in weak else 1.0)]])
        for i in range(20)
    ]
    return csr_array(block_diag(pairs, format="csr")), np.tile(np.eye(2), (20, 1))


def test_a_mechanism_with_positive_pivots_is_told_by_the_growth_of_a_probe(solver):
    """The message names its place, also if the body was regular before."""
    K, modes = pairs_on_weak_ground(2.0**47, weak=range(5, 15))
    sound, _ = pairs_on_weak_ground(8.0)
    factor = solver.factor(sound, modes)
    for take in (lambda: solver.factor(K, modes), lambda: factor.refactor(K)):
        with pytest.raises(NotPositiveDefiniteError, match=r"a probe grew to 1e\+14") as caught:
            take()
        said = re.search(r"at unknown (\d+)\.", str(caught.value))
        assert 10 <= int(said[1]) < 30


def test_a_mechanism_is_told_whichever_way_the_probe_moves_it(solver):
    """Each pair alone: the probe loads both nodes with equal or with opposite signs."""
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (20, 2)).sum(axis=1)
    assert {-2.0, 0.0, 2.0} == set(signs)
    for i, sign in enumerate(signs):
        K, modes = pairs_on_weak_ground(2.0**47, weak=[i])
        if sign:
            with pytest.raises(NotPositiveDefiniteError, match="singular to round-off"):
                solver.factor(K, modes)
        else:
            solver.factor(K, modes)


def test_a_soft_body_is_no_mechanism(solver):
    """The growth is 1000 times that of regular problems and a tenth of that of a free part."""
    K, modes = pairs_on_weak_ground(2.0**41)
    x = solver.factor(K, modes).solve(K @ np.arange(40.0)).x
    np.testing.assert_allclose(x, np.arange(40.0), rtol=1e-3, atol=1e-3)


def test_zero_and_negative_diagonal(solver):
    for entry in (0.0, -1.0):
        with pytest.raises(NotPositiveDefiniteError, match=r"unknown 1\b"):
            solver.factor(csr_array(np.diag([1.0, entry, 2.0])), np.ones((3, 3)))


# Indefinite, but an exchange of rows makes all pivots of the L U factor positive.
EXCHANGED = [
    [[1, 1, 0], [1, 1, 1], [0, 1, 5]],
    [[1, 1, 0, 0, 0], [1, 2, 0, 1, 0], [0, 0, 1, 1, 1], [0, 1, 1, 1, 0], [0, 0, 1, 0, 1]],
    [[2, 0, -1, 1], [0, 2, 1, -1], [-1, 1, 1, 0], [1, -1, 0, 1]],
]


@pytest.mark.parametrize("rows", EXCHANGED, ids=len)
def test_exact_zero_pivot(solver, rows):
    K = csr_array(np.array(rows, float))
    assert np.linalg.eigvalsh(K.toarray())[0] < -0.1
    with pytest.raises(NotPositiveDefiniteError):
        solver.factor(K, np.ones((len(rows), 1)))


def test_nan(solver):
    K, modes = plate()
    with pytest.raises(SolveError, match="right hand side is not finite at unknown 3"):
        solver.factor(K, modes).solve(np.where(np.arange(K.shape[0]) == 3, np.nan, 1.0))
    K.data[K.indptr[7] + 1] = np.inf
    with pytest.raises(SolveError, match="stiffness is not finite in row 7"):
        solver.factor(K, modes)


def test_shapes(solver):
    K, modes = plate()
    with pytest.raises(ValueError, match="unknowns"):
        solver.factor(K, modes).solve(np.ones(3))
    with pytest.raises(ValueError, match="square"):
        solver.factor(K[:4], modes)


def test_unsymmetric_matrix_is_noticed():
    K, modes = plate()
    K.data *= np.linspace(1.0, 1.001, K.nnz)
    for name in filter(solvers.available, DIRECT):
        with pytest.raises(SolveError, match="symmetric"):
            select(1, name).factor(K, modes).solve(np.ones(K.shape[0]))


def test_unsorted_indices(solver):
    K, modes = plate()
    mixed = K.copy()
    for start, end in zip(K.indptr, K.indptr[1:], strict=False):
        mixed.indices[start:end] = K.indices[start:end][::-1]
        mixed.data[start:end] = K.data[start:end][::-1]
    mixed.has_sorted_indices = mixed.has_canonical_format = False
    b = np.ones(K.shape[0])
    expected = solver.factor(K, modes).solve(b).x
    np.testing.assert_array_equal(solver.factor(mixed, modes).solve(b).x, expected)


def test_long_indices(solver):
    K, modes = plate()
    b = np.ones(K.shape[0])
    results = []
    for kind in (np.int32, np.int64):
        same = csr_array(K.shape)
        same.indptr, same.indices, same.data = K.indptr.astype(kind), K.indices.astype(kind), K.data
        results.append(solver.factor(same, modes).solve(b).x)
    np.testing.assert_array_equal(*results)


def test_tiny_systems(solver):
    assert solver.factor(csr_array((0, 0)), np.zeros((0, 3))).solve([]).x.shape == (0,)
    one = solver.factor(csr_array([[4.0]]), np.array([[1.0, 0.0, 0.0]])).solve([2.0])
    np.testing.assert_allclose(one.x, [0.5], rtol=1e-15)
    assert not solver.factor(csr_array([[4.0]]), np.array([[1.0, 0, 0]])).solve([0.0]).x.any()


def test_multigrid_says_how_far_it_got(monkeypatch):
    monkeypatch.setattr(amg, "CG_ITERATIONS", 3)
    K, modes = plate(25, 25)
    with pytest.raises(SolveError, match=r"residual of .* in 3 iterations"):
        select(1, "amg").factor(K, modes)


def test_multigrid_needs_modes():
    with pytest.raises(ValueError, match="rigid"):
        select(1, "amg").factor(plate()[0])


def test_multigrid_does_not_depend_on_the_random_state():
    K, modes = plate(25, 25)
    b = np.ones(K.shape[0])
    results = []
    for seed in (1, 2):
        np.random.seed(seed)  # noqa: NPY002
        before = np.random.get_state()  # noqa: NPY002
        results.append(select(1, "amg").factor(K, modes).solve(b).x)
        np.testing.assert_equal(np.random.get_state(), before)  # noqa: NPY002
    np.testing.assert_array_equal(*results)


THREADS = """
import hashlib, sys
sys.path[:0] = [{folder!r}, {shared!r}]
import numpy as np
from cfmpm.threads import one_blas_thread
from test_solvers import plate, select
K, modes = plate(60, 60)
with one_blas_thread():
    x = select(1, {name!r}).factor(K, modes).solve(np.ones(K.shape[0])).x
print(hashlib.sha256(x.tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_same_bits_for_any_number_of_threads(solver, request):
    code = THREADS.format(
        folder=str(request.path.parent), shared=str(request.path.parents[1]), name=solver.name
    )
    digests = set()
    for threads in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        )
        digests.add(run.stdout)
    assert len(digests) == 1


def test_auto(monkeypatch):
    small, large = 1000, SOLVERS["superlu"].most_unknowns + 1
    installed = {"kvxopt", "rslab"}
    monkeypatch.setattr(solvers, "find_spec", lambda name: name if name in installed else None)
    assert select(small).name == select(large).name == "cholmod"
    installed.remove("kvxopt")
    assert select(small).name == select(large).name == "rslab"
    installed.remove("rslab")
    assert select(small).name == "superlu"
    assert select(large).name == "amg"
    with pytest.raises(SolveError, match="pip install kvxopt"):
        select(small, "cholmod")
    with pytest.raises(ValueError, match="no solver 'pardiso'"):
        select(small, "pardiso")


def test_import_is_light():
    code = (
        "import sys, cfmpm.linear.solvers; print({'pyamg', 'kvxopt', 'rslab'} & set(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"
