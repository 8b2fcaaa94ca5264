"""The fields of a state of equilibrium as the content of one UGRID file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from cfmpm import mechanics
from cfmpm.body.grid import Floats, Grid, Ints, Triangulation
from cfmpm.body.materials import stress_across
from cfmpm.body.points import DeformedPoints, seed
from cfmpm.equilibrium import newton, small_strain
from cfmpm.scene import Scene

if TYPE_CHECKING:
    from cfmpm.state import Result, State


def build_fields(result: Result) -> xr.Dataset:
    """Return the fields of the last state of a run; see `state_fields`."""
    history = result.history
    solved = int(np.flatnonzero(np.isfinite(history["n_unknowns"].values))[-1])
    step, load_factor = int(history["step"][solved]), float(history["load_factor"][solved])
    return state_fields(result, step, load_factor, history.attrs)


def state_fields(
    state: State, step: int, load_factor: float, attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Return the fields of a state of equilibrium by the UGRID conventions 1.0.

    Parameters
    ----------
    state : State
    step : int
    load_factor : float
        Load factor of the fields.
    attributes : mapping
        Attributes of provenance, from `output.provenance`; others are ignored.

    Returns
    -------
    xarray.Dataset
        Dimensions time (one pseudo-time, the step), node, face, corner, point and crack_node.
        Displacement [mm] and configurational force [N/mm] at the nodes; stress [MPa] and energy
        density [N mm/mm^3] on the faces; the material points with position [mm], volume [mm^2 for
        1 mm of thickness] and stress; the corners of the crack lines [mm].

    Notes
    -----
    UGRID has only linear faces. The faces of T3 are the elements; an element of order p is divided
    into p^2 faces, so that every node keeps its values. Each face has the state at its centre: for
    T6 a corner face that of its material point (the sub-triangles of the paper's section 2.3), the
    inner face the mean of the three. The state is evaluated at the initial positions of material
    points in an element, since growth moves nodes relative to the points.
    """
    grid, points = state.grid, state.points
    scale = state.balance.scale(load_factor)
    seeds = _state_at_seeds(state)
    faces, element = linear_faces(grid)
    stress = scale * _with_sigma_zz(points, state)
    face_stress = scale * _on_faces(_with_sigma_zz(seeds, state), grid)

    node: dict[str, Any] = {"mesh": "grid", "location": "node"}
    face: dict[str, Any] = {"mesh": "grid", "location": "face"}
    data: dict[str, Any] = _of_grid(grid, faces, element, face) | {
        "point_volume": ("point", points.volume, _said("mm2", "volume per mm of thickness")),
        "point_element": ("point", points.element.astype(np.int32), _said("1", "element")),
    }
    for i, axis in enumerate("xy"):
        u = scale * state.displacement[:, i]
        force = scale**2 * state.configurational_force[:, i]
        data[f"u_{axis}"] = _now("node", u, node | _said("mm", f"displacement along {axis}"))
        said = _said("N mm-1", f"configurational force along {axis}")
        data[f"cf_{axis}"] = _now("node", force, node | said)
    for i, name in enumerate(("sigma_xx", "sigma_yy", "sigma_xy", "sigma_zz")):
        said = _said("MPa", f"stress {name.removeprefix('sigma_')}")
        data[name] = _now("face", face_stress[:, i], face | said)
        data[f"point_{name}"] = _now("point", stress[:, i], said)
    data["von_mises"] = _now(
        "face", von_mises(face_stress), face | _said("MPa", "equivalent stress of von Mises")
    )
    said = _said("N mm-2", "strain energy per volume (N mm/mm3)")
    energy = scale**2 * _on_faces(seeds.energy, grid)
    data["energy_density"] = _now("face", energy, face | said)
    data["point_energy_density"] = _now("point", scale**2 * points.energy, said)
    data |= _cracks(state.body.triangulation)

    fields = xr.Dataset(
        data, _coordinates(state, step, load_factor), _attributes(state.scene, attributes)
    )
    # VTK's reader copies connectivity and start index into 32 bits without a check: 64-bit values
    # overwrite its memory. Every face has its three corners: with a fill value plain xarray would
    # read the numbers as floats.
    fields["face_nodes"].encoding |= {"_FillValue": None, "dtype": "int32"}
    return fields


def _of_grid(grid: Grid, faces: Ints, element: Ints, face: dict[str, Any]) -> dict[str, Any]:
    """The grid itself: its faces, their elements and regions."""
    return {
        "grid": ((), np.int32(0), _topology()),
        "face_nodes": (
            ("face", "corner"),
            faces.astype(np.int32),
            {
                "cf_role": "face_node_connectivity",
                "long_name": "nodes of a face",
                "start_index": np.int32(0),
            },
        ),
        "element": ("face", element.astype(np.int32), face | _said("1", "element of the grid")),
        "region": (
            "face",
            grid.regions[element].astype(np.int32),
            face
            | _said("1", "part of the body with its own material")
            | {
                "flag_values": np.arange(len(grid.region_names), dtype=np.int32),
                "flag_meanings": _words(grid.region_names),
            },
        ),
    }


def _words(names: Iterable[str]) -> str:
    """Names as CF conventions want them: apart by blanks, with none inside."""
    return " ".join(re.sub(r"[^\w.+@-]", "_", name) for name in names)


def linear_faces(grid: Grid) -> tuple[Ints, Ints]:
    """Divide the elements of a grid into linear triangles, whose corners are all nodes.

    Parameters
    ----------
    grid : Grid

    Returns
    -------
    faces : (f, 3) int
        From `Element.faces`, element by element.
    element : (f,) int
        Element of each face.
    """
    parts = grid.element.faces
    faces = grid.elements[:, parts].reshape(-1, 3)
    return faces, np.repeat(np.arange(len(grid.elements)), len(parts))


def von_mises(stress: Floats) -> Floats:
    """Return the equivalent stress of von Mises.

    Parameters
    ----------
    stress : (n, 4) float
        sigma_xx, sigma_yy, sigma_xy, sigma_zz [MPa].

    Returns
    -------
    (n,) float
        [MPa].
    """
    xx, yy, xy, zz = stress.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2)


def _on_faces(values: Floats, grid: Grid) -> Floats:
    """Values on the faces from those at the initial points, element by element."""
    weights = grid.element.face_weights
    own = values.reshape(len(grid.elements), weights.shape[1], -1)
    on_faces = np.einsum("fq,eqc->efc", weights, own)
    return on_faces.reshape(-1, *values.shape[1:])


def _topology() -> dict[str, Any]:
    return {
        "cf_role": "mesh_topology",
        "long_name": "background grid",
        "topology_dimension": 2,
        "node_coordinates": "node_x node_y",
        "face_node_connectivity": "face_nodes",
        "face_dimension": "face",
    }


def _state_at_seeds(state: State) -> DeformedPoints:
    """The state at the initial positions of material points in the elements of a grid."""
    grid, finite = state.grid, state.balance.finite
    if finite and state.body.quadrature is None:
        return state.points
    seeds = seed(grid)
    gradients = grid.basis_gradients(seeds.element, seeds.position)
    problem = mechanics.problem_of(replace(state.body, points=seeds, quadrature=None), gradients)
    if not finite:
        return small_strain.deform(problem, state.displacement)
    nothing = np.zeros((len(seeds), problem.materials.n_internal))
    return newton.deform(problem, state.displacement, nothing)[0]


def _with_sigma_zz(points: DeformedPoints, state: State) -> Floats:
    """sigma_xx, sigma_yy, sigma_xy, sigma_zz of points, (p, 4)."""
    materials = state.body.materials
    if state.balance.finite:
        across = stress_across(materials, points, state.body.patches)
    else:
        across = np.sum(materials.across[points.material] * points.stress, axis=1)
    return np.column_stack([points.stress, across])


def _cracks(mesh: Triangulation) -> dict[str, Any]:
    """The corners of the crack lines, one line after the other."""
    if not mesh.cracks:
        return {}
    lines = [np.append(pairs[:, 0], pairs[-1, 1]) for pairs in mesh.cracks.values()]
    numbers = np.arange(len(lines), dtype=np.int32)
    names = {"flag_values": numbers, "flag_meanings": _words(mesh.cracks)}
    number = np.repeat(numbers, [len(line) for line in lines])
    corners = mesh.nodes[np.concatenate(lines)]
    return {"crack": ("crack_node", number, _said("1", "crack of a corner") | names)} | {
        f"crack_{axis}": ("crack_node", corners[:, i], _said("mm", f"{axis} of a crack's corner"))
        for i, axis in enumerate("xy")
    }


def crack_length(mesh: Triangulation) -> float:
    """Length of all cracks together [mm]."""
    return float(sum(mesh.crack_lengths.values()))


def _coordinates(state: State, step: int, load_factor: float) -> dict[str, Any]:
    coordinates: dict[str, Any] = {
        # ParaView animates only along a dimension of this name.
        "time": ("time", [float(step)], _said("1", "pseudo-time: the step") | {"axis": "T"}),
        "load_factor": ("time", [load_factor], _said("1", "factor on all loads of the scene")),
        "crack_length": (
            "time",
            [crack_length(state.body.triangulation)],
            _said("mm", "length of all cracks together"),
        ),
    }
    for i, axis in enumerate("xy"):
        x, position = state.grid.nodes[:, i], state.points.position[:, i]
        # xugrid and VTK require the standard name; they accept mm as well as m.
        coordinates[f"node_{axis}"] = (
            "node",
            x,
            _said("mm", f"{axis} of a node, undeformed")
            | {"standard_name": f"projection_{axis}_coordinate"},
        )
        said = _said("mm", f"{axis} of a material point")
        coordinates[f"point_{axis}"] = ("point", position, said)
    return coordinates


def _attributes(scene: Scene, attributes: Mapping[str, Any]) -> dict[str, Any]:
    return {name: attributes[name] for name in _SHARED_ATTRIBUTES if name in attributes} | {
        "Conventions": "CF-1.11, UGRID-1.0, ACDD-1.3",
        "summary": f"A state of scene {scene.name}: grid, material points and cracks",
    }


_SHARED_ATTRIBUTES = (
    "title",
    "source",
    "references",
    "keywords",
    "history",
    "date_created",
    "config",
    "config_hash",
    "versions",
    "threads",
)


def _now(dimension: str, values: Floats, attributes: dict[str, Any]) -> tuple[Any, ...]:
    """A variable at the single time of the file."""
    return ("time", dimension), values[None], attributes


def _said(units: str, long_name: str) -> dict[str, Any]:
    return {"units": units, "long_name": long_name}
