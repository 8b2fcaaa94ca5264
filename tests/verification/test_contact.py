"""Contact of crack faces: exact states, complementarity, energy, stress intensity."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import round_off
from cracked_beams import BEAMS, MATERIAL, bent_beam
from outlines import named_rectangle
from posed import balanced, driven, elastic, pose
from structured import rectangle

from cfmpm import build
from cfmpm.body import body as bodies
from cfmpm.body.crack_faces import face_pairs, smallest_openings
from cfmpm.body.grid import build_grid
from cfmpm.equilibrium import balance, complementarity, contact, small_strain
from cfmpm.errors import SolveError
from cfmpm.fracture import cf
from cfmpm.fracture.interaction import IntensityFactors, intensity_factors
from cfmpm.linear import solvers
from cfmpm.registry.elements import ELEMENTS
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict

MODULUS = 70e3 / (1 - 0.33**2)


@dataclass
class Solved:
    """A solved body and the data for its evaluation."""

    body: bodies.Body
    gradients: np.ndarray
    balance: balance.Equilibrium

    def pressed(self) -> tuple[np.ndarray, np.ndarray]:
        """Opening and normal force of all pairs."""
        gap, force = [], []
        for crack in self.body.grid.crack_faces:
            pairs = face_pairs(self.body.grid, crack)
            gap.append(pairs.opening(self.balance.displacement))
            found = np.zeros(len(pairs.left))
            # Equal, opposite, and without friction: along the normals of the one or two pairs.
            both = self.balance.contact_force[[pairs.left, pairs.right]]
            np.testing.assert_array_equal(both[0], -both[1])
            least = 1e-14 * np.abs(both).max()
            for node in np.unique(pairs.left):
                rows = np.flatnonzero(pairs.left == node)
                acting = self.balance.contact_force[node]
                along = pairs.normal[rows].T
                found[rows] = np.linalg.lstsq(along, acting, rcond=None)[0]
                np.testing.assert_allclose(along @ found[rows], acting, rtol=0, atol=least)
            force.append(np.where(np.abs(found) > least, found, 0.0))
        return np.concatenate(gap), np.concatenate(force)

    def linear(self) -> round_off.LinearBody:
        """Round-off bounds of its sums."""
        grid, points, u = self.body.grid, self.body.integration, self.balance.displacement
        modulus = round_off.stiffest(MATERIAL["E"], MATERIAL["nu"])
        return round_off.LinearBody(grid, points, self.gradients, u, modulus)

    def intensity(self, tip, radius) -> tuple[IntensityFactors, float]:
        """Intensity factors and J."""
        grid, points, nothing = self.body.grid, self.balance.points, np.zeros(2)
        q = cf.ring_weight(grid, tip, radius)
        k = intensity_factors(
            grid,
            points,
            self.gradients,
            self.body.materials,
            tip,
            q,
            nothing,
            self.balance.contact_force,
        )
        nodal = cf.nodal_force(grid, points, self.gradients, nothing)
        return k, cf.j_integral(nodal, np.outer(q, tip.tangent))


def solve(scene: dict, solver: str = "superlu") -> Solved:
    full = expand(scene_from_dict({"name": "contact", "material": MATERIAL, **scene}))
    body = build.build(full)
    problem = pose(body.grid, body.loading, body.materials, solver=solver)
    return Solved(body, problem.gradients, balanced(problem))


def assert_complementary(solved: Solved) -> None:
    """Check: no overlap, no tension, no force at open pairs; the work is the stored energy."""
    gap, force = solved.pressed()
    u, loading = solved.balance.displacement, solved.body.loading
    largest = np.abs(u).max()
    assert (force >= 0.0).all()
    assert np.count_nonzero(force) == solved.balance.contact_pairs
    assert gap.min() > -contact.TOUCH * largest
    assert np.abs(gap[force > 0.0]).max(initial=0.0) < contact.TOUCH * largest
    outer = np.where(
        loading.prescribed,
        solved.balance.internal_force - solved.balance.contact_force,
        loading.proportional.force,
    )
    unbalanced = outer + solved.balance.contact_force - solved.balance.internal_force
    assert np.abs(unbalanced).max() < 1e-10 * np.abs(solved.balance.internal_force).max()
    points = solved.balance.points
    work, energy = 0.5 * (outer * u).sum(), points.energy @ points.volume
    assert work == pytest.approx(energy, abs=solved.linear().of_energy)


def inclined(element, angle):
    graded = {"T3": {"tip_size": 0.05, "growth": 0.15}, "T6": {"tip_size": 0.1, "growth": 0.25}}
    return {
        "family": {
            "kind": "centre_crack",
            "width": 200,
            "height": 200,
            "crack_length": 10,
            "crack_angle": angle,
            "traction": -10,
        },
        "mesh": {"element": element, "size": 25, "grading": graded[element]},
        "fracture": {"radii": 3},
    }


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("beta", [30, 45, 60, -30, -45, -60])
def test_inclined_crack_under_compression(element, beta):
    """Frictionless: K_I = 0, K_II = sigma sin(beta) cos(beta) sqrt(pi a), infinite plate.

    beta is the angle between crack and load; the finite plate of 20 crack lengths adds 0.2 %.
    """
    solved = solve(inclined(element, np.sign(beta) * 90 - beta))
    exact = -10 * np.sin(np.radians(beta)) * np.cos(np.radians(beta)) * np.sqrt(5 * np.pi)
    assert_complementary(solved)
    (tip, other), domains = solved.body.grid.tips, solved.body.tip_domains
    gap, _ = solved.pressed()
    assert gap.min() > -1e-10 * tip.h
    for radius in domains[0].radii:
        for end in (tip, other):
            k, j = solved.intensity(end, radius)
            assert pytest.approx(exact, rel=0.005) == k.K_II
            assert abs(k.K_I) < 0.015 * abs(exact)
            assert j == pytest.approx(exact**2 / MODULUS, rel=0.015)
            assert pytest.approx(exact**2 / MODULUS, rel=0.01) == k.G
            # The T-stress that the uniform stress leaves along a closed crack.
            squeeze = -10 * np.cos(np.radians(2 * beta))
            assert k.T_stress == pytest.approx(squeeze, abs=0.035)


def test_pressure_belongs_in_the_interaction_integral():
    """Without the work of the pressure, K_I depends on the radius and is as large as K_II."""
    solved = solve(inclined("T6", 45))
    tip = solved.body.grid.tips[0]
    wrong = []
    for radius in (1.0, 4.0):
        q = cf.ring_weight(solved.body.grid, tip, radius)
        k = intensity_factors(
            solved.body.grid,
            solved.balance.points,
            solved.gradients,
            solved.body.materials,
            tip,
            q,
            np.zeros(2),
        )
        wrong.append(k.K_I)
    assert wrong[1] < 1.5 * wrong[0] < -5


def edge_crack(traction, element="T6", crack=((0, 27), (30, 27)), side=0.0):
    """Edge crack under `traction` on top and `side` on the lateral edges."""
    return {
        "geometry": {
            "outline": named_rectangle(60, 50),
            "cracks": [{"points": [list(x) for x in crack]}],
        },
        "loads": [
            {"edge": "top", "traction": traction},
            {"edge": "bottom", "traction": [-traction[0], -traction[1]]},
            {"edge": "right", "traction": [side, traction[0]]},
            {"edge": "left", "traction": [-side, -traction[0]]},
        ],
        "mesh": {"element": element, "size": 7, "grading": {"tip_size": 0.5, "growth": 0.3}},
    }


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_uniform_pressure_passes_through_closed_faces(element):
    solved = solve(edge_crack([0, -10.0], element))
    stress = solved.balance.points.stress
    expected = np.tile([0, -10.0, 0], (len(stress), 1))
    np.testing.assert_allclose(stress, expected, rtol=0, atol=solved.linear().of_stress)
    assert_complementary(solved)
    tip = solved.body.grid.tips[0]
    k, j = solved.intensity(tip, 10.0)
    # An uncracked body: what is left is the quadrature of the singular auxiliary field.
    assert abs(k.K_I) < 2e-3 * 10 * np.sqrt(np.pi * 30)
    assert abs(k.K_II) < 2e-3 * 10 * np.sqrt(np.pi * 30)
    assert abs(j) < 1e-12


@pytest.mark.parametrize("element", ["T3", "T6"])
def test_pressure_from_all_sides_passes_through_a_kinked_crack(element):
    """The normal of a pair at a bend is the direction of the pressure: exact at bends, too."""
    crack = [(0, 20), (17, 27), (30, 22), (38, 31)]
    solved = solve(edge_crack([0, -10.0], element, crack, side=-10.0))
    stress = solved.balance.points.stress
    expected = np.tile([-10.0, -10.0, 0], (len(stress), 1))
    np.testing.assert_allclose(stress, expected, rtol=0, atol=solved.linear().of_stress)
    assert_complementary(solved)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("last", [5, 3], ids=["crossing", "meeting"])
def test_pressure_passes_through_joined_cracks(element, last):
    """Where cracks cross or meet, three or four nodes coincide."""
    mesh = rectangle(8, 6, shake=0.3, crack=(3, 1, 7))
    line = 4 * 7 + np.arange(last, 0, -1)
    mesh = replace(mesh, cracks={**mesh.cracks, "crack_2": np.column_stack([line[:-1], line[1:]])})
    grid = build_grid(mesh, element)
    outer = np.unique(np.concatenate([edges.ravel() for edges in grid.edges.values()]))
    squeezed = -0.1 * grid.nodes
    problem = pose(grid, driven(grid, outer, squeezed[outer]), elastic(1.3, 0.9))
    stiffness = small_strain.assemble_stiffness(problem)
    balance = small_strain.solve_linear(problem, stiffness)
    assert balance.contact_pairs >= 8
    error = round_off.of_solution(stiffness, squeezed)
    np.testing.assert_allclose(balance.displacement, squeezed, rtol=0, atol=error)
    pressure = -0.2 * (1.3 + 0.9)
    np.testing.assert_allclose(
        balance.points.stress,
        np.tile([pressure, pressure, 0], (len(balance.points), 1)),
        rtol=0,
        atol=round_off.LinearBody(
            grid, problem.points, problem.gradients, squeezed, 1.3 + 2 * 0.9
        ).of_stress,
    )


@pytest.mark.parametrize("load", [[0, 10.0], [4.0, 10.0]])
def test_open_cracks_know_nothing_of_contact(load, monkeypatch):
    scene = edge_crack(load)
    with_check = solve(scene)
    monkeypatch.setattr(
        small_strain,
        "close_faces",
        lambda faces, prescribed, displacement, factor: contact.Contact(
            displacement, np.zeros_like(displacement), np.zeros(0)
        ),
    )
    without = solve(scene)
    assert with_check.balance.contact_pairs == 0
    assert not with_check.balance.contact_force.any()
    for name in ("displacement", "internal_force"):
        one, other = getattr(with_check.balance, name), getattr(without.balance, name)
        assert one.tobytes() == other.tobytes()
    one, other = with_check.balance.points.stress, without.balance.points.stress
    assert one.tobytes() == other.tobytes()
    tip = with_check.body.grid.tips[0]
    assert with_check.intensity(tip, 10.0) == without.intensity(tip, 10.0)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("cracks", BEAMS.values(), ids=BEAMS)
def test_partly_closed_cracks_of_a_bent_beam(element, cracks):
    solved = solve(bent_beam(element, cracks))
    assert_complementary(solved)
    gap, force = solved.pressed()
    largest = np.abs(solved.balance.displacement).max()
    assert np.count_nonzero(force > 0.0) > 5
    assert np.count_nonzero(gap > 1e-4 * largest) > 5
    for crack, smallest in smallest_openings(solved.body.grid, solved.balance.displacement).items():
        assert -1e-10 * largest < smallest <= 0.0, crack


def test_contact_stiffens_and_lowers_what_the_closed_end_releases(monkeypatch):
    scene = bent_beam("T6", BEAMS["straight"])
    closed = solve(scene)
    monkeypatch.setattr(
        small_strain,
        "close_faces",
        lambda faces, prescribed, displacement, factor: contact.Contact(
            displacement, np.zeros_like(displacement), np.zeros(0)
        ),
    )
    overlapping = solve(scene)
    points = [solved.balance.points for solved in (closed, overlapping)]
    energy = [p.energy @ p.volume for p in points]
    assert energy[0] < energy[1]
    lower, upper = closed.body.grid.tips
    assert lower.path[0][1] < upper.path[0][1]
    k_lower, _ = closed.intensity(lower, 3.0)
    k_upper, j_upper = closed.intensity(upper, 3.0)
    assert abs(k_lower.K_I) < 0.02 * abs(k_lower.K_II)
    assert pytest.approx(j_upper, rel=0.015) == k_upper.G
    assert overlapping.intensity(lower, 3.0)[0].K_I < -0.3 * k_upper.K_I


@pytest.mark.parametrize("solver", ["superlu", "amg"])
def test_solution_grows_with_the_load(solver):
    """Twice the load gives exactly twice the solution; the reversed load is another problem."""
    once = solve(edge_crack([3.0, -10.0]), solver)
    twice = solve(edge_crack([6.0, -20.0]), solver)
    assert once.balance.contact_pairs > 0
    for name in ("displacement", "contact_force", "internal_force"):
        one, two = getattr(once.balance, name), getattr(twice.balance, name)
        if solver == "superlu":
            np.testing.assert_array_equal(2.0 * one, two)
        else:
            np.testing.assert_allclose(2.0 * one, two, rtol=0, atol=1e-7 * np.abs(two).max())
    thrice = solve(edge_crack([9.0, -30.0])).balance
    np.testing.assert_allclose(
        thrice.contact_force,
        3.0 * once.balance.contact_force,
        rtol=0,
        atol=1e-7 * np.abs(thrice.contact_force).max(),
    )
    assert solve(edge_crack([-3.0, 10.0])).balance.contact_pairs == 0


def test_faces_may_lie_on_supports():
    """At the mouth both faces are supported along the normal: no contact there."""
    scene = edge_crack([0, -10.0])
    scene["loads"] = [
        {"edge": "left", "displacement": {"x": 0, "y": 0}},
        {"edge": "top", "traction": [0, -10.0]},
    ]
    solved = solve(scene)
    assert_complementary(solved)
    mouth = (solved.body.grid.nodes[:, 0] == 0) & (solved.body.grid.nodes[:, 1] == 27)
    assert mouth.sum() == 2
    assert not solved.balance.contact_force[mouth].any()
    assert solved.balance.contact_pairs > 0


def test_each_column_is_solved_once(monkeypatch):
    solves = []
    original = solvers.Factor.solve
    monkeypatch.setattr(
        solvers.Factor, "solve", lambda self, b: (solves.append(1), original(self, b))[1]
    )
    solved = solve(bent_beam("T3", BEAMS["two"]))
    pairs = len(solved.pressed()[0])
    # The linear solution, a column for each pair that was ever closed, and the answer.
    assert solved.balance.contact_pairs + 2 <= len(solves) <= pairs + 2


def test_no_end_is_an_error(monkeypatch):
    monkeypatch.setattr(complementarity, "ROUNDS", 1)
    with pytest.raises(SolveError, match=r"after 1 steps .* pairs of nodes still overlap"):
        solve(bent_beam("T6", BEAMS["straight"]))
