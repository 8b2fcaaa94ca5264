"""The nine steps of the method (paper section 4.2), for a stationary crack."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from cfmpm import equilibrium, results
from cfmpm.clock import Clock
from cfmpm.fracture import cf
from cfmpm.fracture.domains import FILL, RESOLVED, Domains, choose_domains
from cfmpm.fracture.evaluation import evaluate_tips
from cfmpm.fracture.opening import smallest_openings
from cfmpm.grid import Floats, Grid, build_grid
from cfmpm.kernels.basis import basis_gradients
from cfmpm.loading import Loading, apply_loads
from cfmpm.materials import lame_constants, region_materials
from cfmpm.meshing import resolved_grading, triangulate
from cfmpm.points import MaterialPoints, locate, seed
from cfmpm.scene import Scene, expand

PHASES = ("grid", "points", "stiffness", "equilibrium", "fracture")


@dataclass(frozen=True)
class Prepared:
    """A scene before its first solve.

    Attributes
    ----------
    scene : Scene
        Expanded: with its geometry, loads and names.
    grid : Grid
    points : MaterialPoints
        Free of stress.
    loading : Loading
    domains : list of Domains
        One a tip.
    """

    scene: Scene
    grid: Grid
    points: MaterialPoints
    loading: Loading
    domains: list[Domains]


@dataclass(frozen=True)
class Result:
    """What a run leaves.

    Attributes
    ----------
    scene : Scene
        Expanded: with its geometry, loads and names.
    history : xarray.Dataset
        The quantities of design and result tables, by step, tip and radius.
    grid : Grid
    points : MaterialPoints
        In the last state of balance.
    loading : Loading
    displacement : (n, 2) float
        Of the grid nodes [mm].
    configurational_force : (n, 2) float
        At the grid nodes [N/mm].
    """

    scene: Scene
    history: xr.Dataset
    grid: Grid
    points: MaterialPoints
    loading: Loading
    displacement: Floats
    configurational_force: Floats


def prepare(scene: Scene, clock: Clock) -> Prepared:
    """Build all that the first solve of a scene starts from.

    Parameters
    ----------
    scene : Scene
    clock : Clock

    Returns
    -------
    Prepared

    Raises
    ------
    SceneError
        Where the scene turns out not to make sense on its grid.
    MeshError
        Where no grid could be made.
    """
    full = expand(scene)
    with clock("grid"):  # step 1: background grid with the cracks as doubled nodes
        grid = build_grid(triangulate(full), full.mesh.element)
    with clock("points"):  # still step 1: material points, loads, domains
        points = seed(grid)
        loading = apply_loads(full, grid, points)
        domains = [choose_domains(grid, tip, full.fracture.radii) for tip in grid.tips]
    return Prepared(full, grid, points, loading, domains)


def run(scene: Scene, announce: Callable[[str], None] = lambda phase: None) -> Result:
    """Solve a scene.

    Parameters
    ----------
    scene : Scene
    announce : callable, optional
        Called with the name of each phase (`PHASES`) as it begins.

    Returns
    -------
    Result

    Raises
    ------
    SceneError
        Where the scene turns out not to make sense on its grid.
    MeshError
        Where no grid could be made.
    SolveError
        Where there is no equilibrium to be found.

    Notes
    -----
    Small strain and linear elasticity need one solve: Newton's loop (5) ends after one iteration,
    positions stay (6), no tip runs (8) and the grid is not reset (9).
    """
    clock = Clock(announce)
    start = prepare(scene, clock)  # step 1
    full, grid, points, loading = start.scene, start.grid, start.points, start.loading
    with clock("points"):  # step 2: triangles of the points, basis gradients
        points.element = locate(grid, points.position, points.element)
        gradients = basis_gradients(grid.nodes, grid.elements, points.element, points.position)
        lame = lame_constants(full, grid.region_names)
        g_c = [material.g_c for material in region_materials(full, grid.region_names)]
    with clock("stiffness"):  # step 3
        stiffness = equilibrium.assemble_stiffness(grid, points, gradients, lame, loading)
    with clock("equilibrium"):  # steps 4 to 6: forces, balance, update of the points
        balance = equilibrium.solve_linear(
            stiffness, grid, points, gradients, lame, loading, full.solver
        )
    with clock("fracture"):  # step 7: configurational force, J, K_I, K_II, T
        nodal = cf.nodal_force(grid, points, gradients, loading.body_force)
        tips = evaluate_tips(
            grid,
            points,
            gradients,
            lame,
            balance.displacement,
            nodal,
            start.domains,
            loading.body_force,
            g_c,
        )
    record = results.StepRecord(
        load_factor=1.0,
        values=tips | _body_values(grid, points, loading, balance),
        seconds=clock.seconds,
    )
    history = results.build_history(
        scene,
        [record],
        tips=[tip.name for tip in grid.tips],
        radii=_nominal_radii(full, start.domains),
        boundaries=list(loading.boundaries),
        notes=_notes(full, grid, loading, balance, start.domains),
    )
    return Result(full, history, grid, points, loading, balance.displacement, nodal)


def _body_values(
    grid: Grid, points: MaterialPoints, loading: Loading, balance: equilibrium.Equilibrium
) -> dict[str, object]:
    """Energies, counts and the forces and displacements of the loaded parts."""
    transmitted = balance.internal_force - loading.own_weight
    u = balance.displacement
    # Prescribed parts work through their reaction, the others through the applied force.
    force = np.where(loading.prescribed, balance.internal_force, loading.force)
    parts = loading.boundaries.values()
    reaction = np.array([transmitted[part.nodes].sum(axis=0) for part in parts]).reshape(-1, 2)
    motion = np.array([part.weights @ u[part.nodes] for part in parts]).reshape(-1, 2)
    return {
        "strain_energy": points.energy @ points.volume,
        "external_work": 0.5 * (force * u).sum(),
        "fracture_energy": 0.0,
        "newton_iterations": 0,
        "residual_norm": balance.residual_norm,
        "negative_pivots": balance.negative_pivots,
        "n_points": len(points),
        "n_nodes": len(grid.nodes),
        "n_unknowns": balance.n_unknowns,
        "reaction_x": reaction[:, 0],
        "reaction_y": reaction[:, 1],
        "displacement_x": motion[:, 0],
        "displacement_y": motion[:, 1],
    }


def _nominal_radii(scene: Scene, domains: list[Domains]) -> list[float]:
    """The radii asked for, else those of the tip with the most room."""
    if not isinstance(scene.fracture.radii, int):
        return list(scene.fracture.radii)
    if not domains:
        return []
    return list(max((domain.radii for domain in domains), key=max))


def _notes(
    scene: Scene,
    grid: Grid,
    loading: Loading,
    balance: equilibrium.Equilibrium,
    domains: list[Domains],
) -> dict[str, object]:
    """Say what was chosen and what was left out."""
    grading = resolved_grading(scene)
    notes: dict[str, object] = {
        "formulation": "total Lagrangian, small strain: one linear solve",
        "element": scene.mesh.element,
        "solver": balance.solver,
        "linear_iterations": balance.iterations,
        "rigid_motions_held": loading.held,
        "left_out": left_out(scene, grid),
        "warnings": _warnings(grid, balance, domains),
    }
    if grading is not None:
        notes |= {"grid_tip_size": grading.tip_size, "grid_growth": grading.growth}
    if domains:
        notes |= {
            "domain_clearance": [domain.clearance for domain in domains],
            "domain_cut_back": [int(domain.cut_back) for domain in domains],
            "domain_note": (
                "a domain fills at most 0.9 of the clearance of its tip, so that it holds no "
                "outline, hole, other crack or tip, bend, support or other material"
            ),
        }
    return notes


def _warnings(grid: Grid, balance: equilibrium.Equilibrium, domains: list[Domains]) -> list[str]:
    """Name what makes numbers of this run doubtful."""
    largest = np.abs(balance.displacement).max(initial=0.0)
    found = [
        f"{name}: its faces overlap by up to {-opening:.3g} mm; contact is not modelled, so K_I, "
        "G and the configurational force of its tips mean nothing there"
        for name, opening in smallest_openings(grid, balance.displacement).items()
        if opening < -1e-6 * largest
    ]
    if balance.residual_floor > 0.0:
        found.append(
            f"the unbalanced force, {balance.residual_norm:.1e} of the largest nodal force, is at "
            f"the floor that round-off sets ({balance.residual_floor:.1e}): a strong contrast of "
            "stiffness, or a slender ligament"
        )
    for tip, domain in zip(grid.tips, domains, strict=True):
        if domain.cut_back:
            found.append(
                f"{tip.name}: radii asked for were cut back to {max(domain.radii):.4g} mm, which "
                f"is {FILL} of the distance to what a domain must not hold"
            )
        if max(domain.radii) < RESOLVED * tip.h:
            found.append(
                f"{tip.name}: the largest domain, {max(domain.radii):.3g} mm, reaches over less "
                f"than {RESOLVED:g} elements of {tip.h:.3g} mm; make mesh.grading.tip_size smaller"
            )
    return found


def left_out(scene: Scene, grid: Grid) -> list[str]:
    """List what a run of this scene does not do because the scene does not need it.

    Parameters
    ----------
    scene : Scene
        Expanded.
    grid : Grid

    Returns
    -------
    list of str
    """
    items = [
        "Newton loop, finite deformation: the scene is linear",
        "crack growth, grid reset: the cracks are stationary",
    ]
    if not grid.tips:
        items.append("configurational force at tips: the scene has no crack tip")
    elif scene.fracture.radii == 1 or (
        isinstance(scene.fracture.radii, list) and len(scene.fracture.radii) == 1
    ):
        items.append("spread over radii: one radius only (fracture.radii: 3 asks for three)")
    if scene.material.g_c is None:
        items.append("load at fracture: no material.g_c")
    if not scene.output.fields:
        items.append("field output: not asked for (output.fields: true)")
    return items
