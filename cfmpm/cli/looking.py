"""The commands that solve nothing new: check, plot, export, schema."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cfmpm.cli.app import (
    FAILED,
    Output,
    Overrides,
    SceneFile,
    announce_size,
    app,
    fail,
    problems_placed,
    read_overrides,
    readable,
    tell,
    told_as_damage,
    writable,
)
from cfmpm.cli.running import (
    log_phase,
)
from cfmpm.errors import SceneError

if TYPE_CHECKING:
    import xarray as xr

    from cfmpm.output.record import Record
    from cfmpm.state import State

    Announce = Callable[[str], None]
    Observe = Callable[[State, Record], None]


class Format(StrEnum):
    """Formats for the export of results."""

    vtu = "vtu"


class Kind(StrEnum):
    """Kinds of input files."""

    scene = "scene"
    study = "study"


@app.command(short_help="Mesh, load and draw a scene without solving it.")
def check(scene_file: SceneFile, set_: Overrides = None, output: Output = None) -> None:
    """Mesh a scene, apply its loads, describe what a run would do, and draw it; solve nothing.

    Example: cfmpm check configs/examples/general.yaml --output /tmp/look
    """
    from cfmpm import build
    from cfmpm.linear import solvers
    from cfmpm.output import choices, summary
    from cfmpm.plotting.files import save_scene
    from cfmpm.scene import expand, load_scene

    overrides = read_overrides(set_)
    scene = load_scene(scene_file, overrides)
    folder = writable(output, Path("results") / scene.name)
    announce_size(scene)
    full = expand(scene)
    with problems_placed(scene, scene_file, overrides):
        start = build.build(scene)
    solver = solvers.select(int((~start.loading.prescribed).sum()), scene.solver).name
    finite = full.kinematics == "finite"
    left_out = choices.left_out(full, bool(start.grid.tips), finite=finite)
    path = save_scene(folder, scene, start)
    typer.echo(summary.of_check(full, start, solver, left_out, path))


@app.command(short_help="Draw a result.")
def plot(
    result: Annotated[
        Path,
        typer.Argument(metavar="RESULT", readable=False, help="folder of a run, or its history.nc"),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", readable=False, help="folder to write to; default: that of the result"
        ),
    ] = None,
) -> None:
    """Draw a result: scene.png, deformed.png, and for each tip mesh_<tip>.png, cf_<tip>.png.

    With several domain radii also radii_<tip>.png; with steps at several loads
    force_<part>_<axis>.png, and steps_<tip>.png or, for growth, load.png. For growth also
    paths.png, cf.png, factors.png, angles.png, energy.png; for fatigue cycles.png; and, with
    output.every, growth.gif.

    Without fields.nc the scene is solved again, from the configuration stored in history.nc; for
    growth, deformed.png and cf_<tip>.png are then omitted.

    Example: cfmpm plot results/single_edge_crack
    """
    from cfmpm.accessor import open_history
    from cfmpm.output.run_folder import HISTORY

    source = result / HISTORY if readable(result).is_dir() else result
    history = open_history(source)
    folder = writable(output, source.parent)
    with told_as_damage(source):
        written = _draw(source, history, folder)
    for path in written:
        typer.echo(path)


def _draw(source: Path, history: xr.Dataset, folder: Path) -> list[Path]:
    """Draw all pictures of a result, whose history is `source`."""
    from cfmpm import build, simulation
    from cfmpm.accessor import History
    from cfmpm.output.fields import build_fields
    from cfmpm.output.fields_by_step import fields_of_last_step
    from cfmpm.output.reading import read_result
    from cfmpm.output.run_folder import FIELDS, INDEX
    from cfmpm.plotting import animate_growth, files
    from cfmpm.scene import expand

    scene = History(history).scene
    full = expand(scene)
    fields_file = source.parent / FIELDS
    fields = read_result(fields_file, "face_nodes") if fields_file.exists() else None
    if fields is not None and fields.attrs["config_hash"] != history.attrs["config_hash"]:
        tell(f"{fields_file} belongs to another run: not used")
        fields = None
    by_step = (source.parent / INDEX).exists()
    if fields is None and by_step:
        with suppress(SceneError):  # the film names the reason
            fields = fields_of_last_step(source.parent, history)
    if fields is None and scene.growth is None:
        tell(f"this run has no fields: solving {scene.name} again")
        solved = simulation.run(scene, log_phase)
        fields, state = build_fields(solved), solved.body
    else:
        state = build.build(scene)

    written = [files.save_scene(folder, scene, state)]
    written += files.save_tip_points(folder, state) + files.save_radii(folder, history)
    written += files.save_steps(folder, history)
    if scene.growth is not None:
        written += files.save_growth(folder, history, full, state.grid)
        if by_step:
            try:
                written.append(animate_growth(source.parent, folder / "growth.gif"))
            except SceneError as error:  # the other figures do not depend on it
                tell(f"no film: {error}")
    if fields is None:
        tell("no fields of the last step; output.fields: true writes them")
    else:
        written.append(files.save_deformed(folder, fields))
        written += files.save_tip_forces(folder, fields, history)
    return written


@app.command(short_help="Write a result for ParaView.")
def export(
    result: Annotated[Path, typer.Argument(metavar="DIR", readable=False, help="folder of a run")],
    format_: Annotated[
        Format, typer.Option("--format", help="vtu: VTU files, and PVD files over the steps")
    ] = Format.vtu,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            readable=False,
            help="folder to write to; default: vtu in that of the result",
        ),
    ] = None,
) -> None:
    """Write grid, material points and cracks of a run with fields for ParaView.

    Example: cfmpm export results/plate_with_holes
    """
    from cfmpm.output.run_folder import EXPORT, require_own
    from cfmpm.output.vtu import export_vtu

    folder = writable(output, require_own(readable(result), EXPORT))
    try:
        with told_as_damage(result):
            written = export_vtu(result, folder)
    except ImportError:
        fail("cfmpm: export needs pyvista: pip install 'cfmpm[export]'", FAILED)
    for path in written:
        typer.echo(path)


@app.command()
def schema(
    kind: Annotated[Kind, typer.Argument(help="kind of file")] = Kind.scene,
) -> None:
    """Print the JSON schema of scene or study files, for editors.

    Example: cfmpm schema > schema.json
    """
    from cfmpm.scene.model import Scene
    from cfmpm.scene.schema import schema_text
    from cfmpm.study.model import Study

    typer.echo(schema_text(Scene if kind is Kind.scene else Study), nl=False)
