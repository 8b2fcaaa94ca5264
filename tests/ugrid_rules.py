"""Conformance rules of UGRID 1.0 for one mesh of faces, and additional needs of readers.

R and A numbers are those of the conformance document of the conventions.
"""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np

INT32 = np.dtype(np.int32)


def broken_rules(path: Path) -> list[str]:
    """Return every rule that a file breaks."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        variables = file.variables.values()
        meshes = [v for v in variables if _get(v, "cf_role") == "mesh_topology"]
        if len(meshes) != 1:
            return [f"R101, R102: {len(meshes)} meshes; VTK reads one"]
        (mesh,) = meshes
        rules = _mesh_rules(file, mesh) | _connectivity_rules(file, mesh)
        for v in variables:
            if _get(v, "mesh"):
                rules |= _data_rules(v, mesh, _dimensions(file, mesh))
        rules["A903: Conventions"] = "UGRID-1.0" in str(_get(file, "Conventions"))
    return [rule for rule, holds in rules.items() if not holds]


def _get(of: netCDF4.Variable | netCDF4.Dataset, attribute: str) -> object:
    return of.getncattr(attribute) if attribute in of.ncattrs() else ""


def _coordinates(file: netCDF4.Dataset, mesh: netCDF4.Variable) -> list[netCDF4.Variable]:
    names = str(_get(mesh, "node_coordinates")).split()
    return [file[name] for name in names if name in file.variables]


def _dimensions(file: netCDF4.Dataset, mesh: netCDF4.Variable) -> dict[str, str]:
    """Dimension of each location (node, edge, face)."""
    found = {"face": str(_get(mesh, "face_dimension"))}
    for x in _coordinates(file, mesh):
        found["node"] = x.dimensions[0]
    return found


def _mesh_rules(file: netCDF4.Dataset, mesh: netCDF4.Variable) -> dict[str, bool]:
    coordinates = _coordinates(file, mesh)
    known = ("node_coordinates", "face_node_connectivity", "face_dimension", "topology_dimension")
    endings = ("_coordinates", "_connectivity", "_dimension")
    rules = {
        "R103, R104: topology_dimension": _get(mesh, "topology_dimension") == 2,
        "R108, R110: node_coordinates": len(coordinates) == 2,
        "R113: face_node_connectivity": bool(_get(mesh, "face_node_connectivity")),
        "R117: face_dimension": _get(mesh, "face_dimension") in file.dimensions,
        "A101: the mesh has no dimensions": mesh.dimensions == (),
        "A106: only attributes of UGRID": all(
            name in known for name in mesh.ncattrs() if name.endswith(endings)
        ),
    }
    for x in coordinates:
        rules |= {
            f"R201, R202: one dimension of {x.name}": x.dimensions == coordinates[0].dimensions,
            f"A202: {x.name} is of floats": x.dtype.kind == "f",
            f"A203: standard_name of {x.name}": _get(x, "standard_name")
            in ("projection_x_coordinate", "projection_y_coordinate"),
            f"A204: units of {x.name}": bool(_get(x, "units")),
            f"CF: no fill value of {x.name}": "_FillValue" not in x.ncattrs(),
        }
    return rules


def _connectivity_rules(file: netCDF4.Dataset, mesh: netCDF4.Variable) -> dict[str, bool]:
    name = str(_get(mesh, "face_node_connectivity"))
    if name not in file.variables:
        return {"R109: the connectivity exists": False}
    faces, dims = file[name], _dimensions(file, mesh)
    start = np.asarray(_get(faces, "start_index"))
    has_gaps = "_FillValue" in faces.ncattrs()  # only faces of several forms need it
    fill = np.asarray(_get(faces, "_FillValue") if has_gaps else np.int32(-1))
    real = np.ma.getdata(faces[:])[np.ma.getdata(faces[:]) != fill]
    shift = 1 if start == 1 else 0
    return {
        "R301 to R303: cf_role": _get(faces, "cf_role") == "face_node_connectivity",
        "R304, R307: dimensions": faces.ndim == 2 and faces.dimensions[0] == dims["face"],
        "R306: the second dimension is that of no element": faces.dimensions[-1]
        not in dims.values(),
        "R309: start_index": start in (0, 1),
        "R311: three corners": bool(((np.ma.getdata(faces[:]) != fill).sum(axis=1) >= 3).all()),
        "A302, A303, A306, VTK: 32 bits": {faces.dtype, fill.dtype, start.dtype} == {INT32},
        "A307: the fill value is negative": fill.dtype == INT32 and bool(fill < 0),
        "A308: the nodes exist": "node" in dims
        and bool(
            (real >= shift).all() and (real < file.dimensions[dims["node"]].size + shift).all()
        ),
    }


def _data_rules(
    v: netCDF4.Variable, mesh: netCDF4.Variable, dims: dict[str, str]
) -> dict[str, bool]:
    own = dims.get(str(_get(v, "location")))
    return {
        f"R502: mesh of {v.name}": _get(v, "mesh") == mesh.name,
        f"R503 to R505: location of {v.name}": own is not None,
        f"R509, R510: dimensions of {v.name}": [d for d in v.dimensions if d in dims.values()]
        == [own],
        f"VTK: {v.name} has no dimension but time besides": set(v.dimensions) <= {"time", own},
        f"CF: units and long_name of {v.name}": bool(_get(v, "units") and _get(v, "long_name")),
    }
