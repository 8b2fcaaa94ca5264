"""Export of results as VTU files for ParaView, by pyvista (extra ``export``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from cfmpm.errors import Problem, SceneError
from cfmpm.output.fields_by_step import list_fields, require_same_run
from cfmpm.output.files import file_named, written_aside
from cfmpm.output.reading import read_result
from cfmpm.output.run_folder import FIELDS, HISTORY, INDEX

if TYPE_CHECKING:
    import pyvista

    from cfmpm.body.grid import Floats


def export_vtu(folder: Path, output: Path) -> list[Path]:
    """Write the fields of a run as VTU files, a set for each step, and PVD files over the steps.

    Parameters
    ----------
    folder : Path
        Folder of a run with ``output.every`` or, for the last state only, ``output.fields``.
    output : Path
        Folder to write to; made if needed.

    Returns
    -------
    list of Path
        grid.pvd (the background grid with its fields), points.pvd (the material points) and, where
        there are cracks, cracks.pvd (their lines). Time is the step. Vectors have a z component of
        zero, as ParaView requires.

    Raises
    ------
    ImportError
        If pyvista is missing.
    SceneError
        If there is no run, or it has no fields, if they cannot be read, or if they belong to
        another run than the history in the same folder.
    """
    import pyvista  # noqa: F401 - reports a missing pyvista before any file is read

    folder = Path(folder)
    if (folder / INDEX).exists():
        sources = list_fields(folder)
    elif (folder / FIELDS).exists():
        sources = [folder / FIELDS]
        require_same_run(folder, read_result(sources[0], "face_nodes"), FIELDS)
    else:
        read_result(folder / HISTORY, "domain_radius")
        reason = "no fields; a run with output.fields or output.every writes them"
        raise SceneError([Problem(reason, file=str(folder))])
    with _made(Path(output)):
        kinds: dict[str, list[tuple[float, str]]] = {}
        for source in sources:
            fields = read_result(source, "face_nodes").isel(time=-1)
            step = float(fields["time"])
            for kind, mesh in _meshes(fields).items():
                name = f"{kind}_{step:04.0f}.vtu"
                with written_aside(output / name) as aside:
                    _write(aside, _text_of(mesh))
                kinds.setdefault(kind, []).append((step, name))
        return [_write_collection(output / f"{kind}.pvd", files) for kind, files in kinds.items()]


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Make a folder, which goes again if the ``with`` block fails and has left nothing in it."""
    there = folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        if not there and not any(folder.iterdir()):
            folder.rmdir()
        raise


def _write(path: Path, text: str) -> None:
    with file_named(path):
        path.write_text(text)


def _text_of(mesh: pyvista.UnstructuredGrid) -> str:
    """A mesh as the text of a VTU file: VTK itself tells no reason where it cannot write one."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(mesh)
    writer.SetDataModeToBinary()  # as base64
    writer.WriteToOutputStringOn()
    writer.Write()
    text: str = writer.GetOutputString()
    return text


def _meshes(fields: xr.Dataset) -> dict[str, pyvista.UnstructuredGrid]:
    import pyvista

    def array(name: str) -> Floats:
        values: Floats = fields[name].values
        return values

    def vector(name: str) -> Floats:
        x = array(f"{name}_x")
        return np.column_stack([x, array(f"{name}_y"), np.zeros(len(x))])

    grid = pyvista.UnstructuredGrid(
        {pyvista.CellType.TRIANGLE: array("face_nodes").astype(np.int64)}, vector("node")
    )
    points = pyvista.PolyData(vector("point")).cast_to_unstructured_grid()
    for name, variable in fields.data_vars.items():
        if variable.dims == ("face",):
            grid.cell_data[str(name)] = variable.values
        elif variable.dims == ("point",):
            points.point_data[str(name).removeprefix("point_")] = variable.values
    grid.point_data["u"], grid.point_data["cf"] = vector("u"), vector("cf")
    meshes = {"grid": grid, "points": points}
    if "crack" in fields:
        crack = array("crack")
        ends = np.flatnonzero(np.diff(crack)) + 1
        lines = np.split(np.arange(len(crack)), ends)
        cells = np.concatenate([np.r_[len(line), line] for line in lines])
        tracks = pyvista.PolyData(vector("crack"), lines=cells)
        tracks.cell_data["crack"] = np.array([crack[line[0]] for line in lines], np.int32)
        meshes["cracks"] = tracks.cast_to_unstructured_grid()
    return meshes


def _write_collection(path: Path, files: Sequence[tuple[float, str]]) -> Path:
    """Write a PVD file, which lists the files with their times."""
    entries = "".join(
        f'    <DataSet timestep="{step:g}" part="0" file={quoteattr(name)}/>\n'
        for step, name in files
    )
    with written_aside(path) as aside:
        _write(
            aside,
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
            f"{entries}  </Collection>\n</VTKFile>\n",
        )
    return path
