"""The measurements of speed, on grids too small to measure."""

from __future__ import annotations

import numpy as np
import xarray as xr

from workflows.performance import figures, newton_cost, scaling, work_precision

GRIDS = [
    {"element": "T3", "size": 80, "grading": "uniform"},
    {"element": "T3", "size": 50, "grading": "uniform"},
]


def test_both_programs_make_the_same_error(scene_file, tmp_path):
    series = {"T3 uniform": GRIDS, "T6 uniform": [{**mesh, "element": "T6"} for mesh in GRIDS]}
    path = tmp_path / "work.nc"
    work_precision.measure(
        path,
        scene_file,
        converged=0.2547822,
        radius=90.0,
        repeats=1,
        solvers=["superlu", "amg"],
        series=series,
    )
    dataset = xr.load_dataset(path)
    assert (dataset.seconds > 0).all()
    for name in series:
        here = dataset.isel(run=np.flatnonzero(dataset.series == name))
        for unknowns in np.unique(here.n_unknowns):
            same = here.error.values[here.n_unknowns == unknowns]
            assert len(same) >= 3
            np.testing.assert_allclose(same, same[0], rtol=1e-6)
    figures.draw_work_precision(path, tmp_path / "work.png")
    assert (tmp_path / "work.png").stat().st_size > 10_000


def test_scaling(scene_file, tmp_path):
    path = tmp_path / "scaling.nc"
    series = {"T3": GRIDS, "T6": [{**mesh, "element": "T6"} for mesh in GRIDS]}
    scaling.measure(path, scene_file, solver="superlu", repeats=1, series=series)
    dataset = xr.load_dataset(path)
    assert dict(dataset.sizes) == {"element": 2, "rank": 2, "phase": 5}
    assert np.isfinite(dataset.exponent).all()
    figures.draw_scaling(path, tmp_path / "scaling.png")
    assert (tmp_path / "scaling.png").stat().st_size > 10_000


def test_newton_cost_tells_assembly_from_solution(tmp_path):
    path = tmp_path / "cost.nc"
    loads = [
        {"edge": "bottom", "displacement": {"y": -5}},
        {"edge": "top", "displacement": {"y": 5}},
    ]
    newton_cost.measure(
        path,
        "configs/paper/large_strain.yaml",
        solver="superlu",
        repeats=1,
        replaced={"loads": loads, "load_steps": 1},
        meshes=[GRIDS[0], {**GRIDS[0], "element": "T6"}],
    )
    dataset = xr.load_dataset(path)
    assert list(dataset.element.values) == ["T3", "T6"]
    assert list(dataset.part.values) == list(newton_cost.PARTS)
    assert (dataset.microseconds > 0).all()
    # A run has a whole iteration in it, for each that it counts.
    assert (dataset.whole > 0.5 * dataset.microseconds.sum("part")).all()
