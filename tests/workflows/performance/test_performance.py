"""The performance studies, on very small grids."""

from __future__ import annotations

import re
from functools import partial

import numpy as np
import pytest
import xarray as xr

from cfmpm.scene import load_scene
from cfmpm.simulation import run
from workflows.performance import (
    defaults,
    figures,
    newton_cost,
    scaling,
    study_overhead,
    work_precision,
)
from workflows.performance.alone import run_alone
from workflows.performance.pareto import pareto_front
from workflows.performance.settings import each_value
from workflows.performance.timed_run import fem_solvers
from workflows.reference import plate_fem
from workflows.study.solved import solved

EDGE = {
    "replaced": {},
    "exact": {"G": 0.2547822},
    "solvers": ["cholmod", "rslab", "superlu", "amg"],
    "radii": [30.0, 60.0, 90.0],
    "solved": {
        "T3 uniform": {
            "mesh.element": ["T3"],
            "mesh.grading": ["uniform"],
            "mesh.size": [80, 50],
        },
        "T6 uniform": {"mesh.element": ["T6"], "mesh.grading": ["uniform"], "mesh.size": [80]},
    },
    "axes": [
        {
            "mesh.element": ["T6"],
            "mesh.size": [70, 35],
            "mesh.grading.tip_size": [3.5, 0.35],
            "mesh.grading.growth": [0.3, 0.4],
        }
    ],
}
SHEAR = {
    "replaced": {},
    "exact": {"G": 0.0534700, "K_I": 107.652, "K_II": 14.34706},
    "solvers": ["cholmod", "rslab", "superlu"],
    "radii": [3.0, 20.0],
    "solved": {
        "T6 graded": {
            "mesh.element": ["T6"],
            "mesh.size": [10.6],
            "mesh.grading.growth": [0.3],
            "mesh.grading.tip_size": [0.05],
        },
    },
    "axes": [
        {
            "mesh.element": ["T6"],
            "mesh.size": [10.6, 5.3],
            "mesh.grading.tip_size": [0.53, 0.053],
            "mesh.grading.growth": [0.3, 0.4],
        }
    ],
}
# Formulation and law are axes as any other: nothing but these lines knows of them.
PULLED = {
    "replaced": {
        "material.law": "neo_hookean",
        "load_steps": 2,
        "loads": [
            {"edge": "bottom", "displacement": {"y": -10}},
            {"edge": "top", "displacement": {"y": 10}},
        ],
    },
    "exact": {"G": 30_000.0},
    "solvers": ["cholmod", "superlu"],
    "radii": [50.0, 90.0],
    "solved": {
        "T6 uniform": {"mesh.element": ["T6"], "mesh.grading": ["uniform"], "mesh.size": [80]}
    },
    "axes": [
        {
            "mesh.element": ["T3"],
            "mesh.size": [80],
            "mesh.grading.tip_size": [20],
            "formulation": ["updated"],
            "updated.grid": ["fixed", "following"],
            "material.law": ["neo_hookean", "ciarlet"],
        }
    ],
}
PATH = {
    "replaced": {},
    "reference": "shear_plate_limit",
    "tip": None,
    "release": None,
    "axes": [
        {
            "mesh.element": ["T3"],
            "mesh.grading": ["uniform"],
            "mesh.size": [8],
            "growth.order": [1, 2],
            "growth.direction": ["cf", "max_hoop"],
        },
        {"mesh.element": ["T6"], "mesh.size": [8], "fracture.refine": [4], "growth.order": [1]},
    ],
}
LINE = {
    "replaced": {"material.E": 210e3},
    "reference": "edge_crack_line",
    "tip": "crack_1",
    "release": "edge_crack_release",
    "axes": [{"mesh.element": ["T3"], "mesh.grading": ["uniform"], "mesh.size": [50, 25]}],
}


@pytest.fixture(scope="module")
def measured(root, tmp_path_factory):
    path = tmp_path_factory.mktemp("work") / "work.nc"
    paper = root / "configs/paper"
    work_precision.measure(
        path,
        repeats=1,
        stationary={
            "edge crack": {"scene": str(paper / "single_edge_crack.yaml"), **EDGE},
            "shear plate": {"scene": str(paper / "shear_plate.yaml"), **SHEAR},
            "pulled plate": {"scene": str(paper / "large_strain.yaml"), **PULLED},
        },
        paths={
            "shear path": {"scene": str(paper / "shear_plate_growth.yaml"), **PATH},
            "straight path": {"scene": str(paper / "edge_crack_growth.yaml"), **LINE},
        },
    )
    return path


def of(dataset, **chosen):
    """The runs with these values."""
    here = np.ones(dataset.sizes["run"], bool)
    for name, value in chosen.items():
        here &= (dataset[name] == value).values
    return dataset.isel(run=np.flatnonzero(here))


def test_every_combination_is_a_run(measured):
    dataset = xr.load_dataset(measured)
    assert (dataset.cpu > 0).all()
    assert (dataset.seconds.sel(phase=["mesh", "solve"]) > 0).all()
    for problem, wanted in (("edge crack", 8), ("shear plate", 8)):
        runs = of(dataset, problem=problem, part="grading")
        keys = zip(*(runs[name].values for name in ("size", "tip_size", "growth")), strict=True)
        assert len(set(keys)) == runs.sizes["run"] == wanted
        assert of(dataset, problem=problem, part="default").sizes["run"] == 1
    paths = of(dataset, problem="shear path", part="path")
    assert paths.order.values.tolist() == [1.0, 1.0, 2.0, 2.0, 1.0]
    default = of(dataset, problem="shear path", part="default")
    assert default.direction.item() == "max_hoop"
    radii = of(dataset, problem="edge crack", part="radius", series="T6 uniform").radius
    np.testing.assert_allclose(radii, [30, 60, 90])
    radii = of(dataset, problem="edge crack", part="radius", series="T3 uniform")
    np.testing.assert_allclose(radii.radius, [30, 60, 90])
    assert (radii["size"] == 50).all()  # the finest grid alone


def test_formulation_and_law_are_axes(measured, tmp_path):
    dataset = of(xr.load_dataset(measured), problem="pulled plate")
    runs = of(dataset, part="grading")
    pairs = zip(runs.formulation.values, runs.law.values, strict=True)
    assert set(pairs) == {
        (f"updated, {grid} grid, by points", law)
        for grid in ("fixed", "following")
        for law in ("neo_hookean", "ciarlet")
    }
    default = of(dataset, part="default")
    assert (default.formulation.item(), default.law.item()) == ("total", "neo_hookean")
    assert set(dataset.program.values) == {"cfmpm"}
    page = tmp_path / "page.html"
    defaults.write_defaults(measured, {}, page)
    rows = re.findall(r"<tr.*?</tr>", page.read_text(encoding="utf-8"))
    for axis, told in (
        *(("formulation", "total: "), ("law", "neo_hookean: "), ("element", "T6: ")),
        ("grading", "graded: "),
    ):
        assert any(f"<td>{axis}</td>" in row and f"<td>{told}" in row for row in rows), axis


def test_what_does_not_come_to_its_load_has_no_error(root):
    """Hencky's law under a dead load without equilibrium."""
    replaced = {"loads": [], "family.traction": 100e3, "load_steps": 4}
    replaced |= {"mesh": {"element": "T3", "size": 80, "grading": "uniform"}}
    scene = str(root / "configs/paper/large_strain.yaml")
    plan = work_precision._study(scene, 1, replaced, {})
    told = partial(work_precision._at_rest, exact={"G": 1.0})
    (row,) = work_precision.Sweep({}, [], plan, told).rows(*solved([plan]))
    assert row["cpu"] > 0.0
    assert np.isnan(row["error"]).all()


def test_both_programs_make_the_same_error(measured):
    dataset = of(xr.load_dataset(measured), part="solvers")
    edge = of(dataset, problem="edge crack")
    assert set(edge.solver.values) >= {"superlu", "amg", "its default"}
    for element, unknowns in set(zip(edge.element.values, edge.n_unknowns.values, strict=True)):
        same = of(edge, element=element, n_unknowns=unknowns)
        assert set(same.program.values) == {"cfmpm", "scikit-fem"}
        J = same.error.sel(quantity="J")
        np.testing.assert_allclose(J, J[0], rtol=1e-6)
    # K by other auxiliary fields and another quadrature: the same but for the error of the ring.
    shear = of(dataset, problem="shear plate")
    own, fem = (of(shear, program=name).isel(run=0).error for name in ("cfmpm", "scikit-fem"))
    np.testing.assert_allclose(fem, own, atol=5e-5)
    assert float(own.max()) < 2e-3


def test_scikit_fem_finds_the_factors_of_a_known_plate(root):
    """K_I = 107.652, K_II = 14.347 MPa mm^0.5: shear plate, to 1e-3 on this grid."""
    mesh = {"element": "T6", "size": 8, "grading": {"tip_size": 0.02, "growth": 0.3}}
    result = run(load_scene(root / "configs/paper/shear_plate.yaml", {"mesh": mesh}))
    system = plate_fem.assemble(plate_fem.plate_of(result.scene, result.grid), degree=2)
    solution = plate_fem.solve(system, next(iter(fem_solvers().values())))
    tip = result.grid.nodes[result.grid.tips[0].node]
    for radius in (5.0, 20.0):
        K_I, K_II = plate_fem.intensity_factors(solution, tip, radius)
        assert pytest.approx(107.652, rel=1e-3) == K_I
        assert pytest.approx(14.34706, rel=1e-3) == K_II
        J = plate_fem.j_integral(solution, tip, radius)
        assert system.plate.release_rate(K_I, K_II) == pytest.approx(J, rel=1e-3)


def test_figures_and_page(measured, tmp_path):
    for name in ("work_precision", "paths", "grading", "solvers"):
        getattr(figures, f"draw_{name}")(measured, tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    page = tmp_path / "defaults.html"
    defaults.write_defaults(measured, {"Solvers": tmp_path / "solvers.png"}, page)
    text = page.read_text(encoding="utf-8")
    for word in ("edge crack", "shear plate", "shear path", "order 1", "data:image/png"):
        assert word in text


def test_a_path_has_its_distance_and_the_error_of_values_along_it(measured):
    """Both are smaller on the finer grid; by default G is within 0.3 % on the whole path."""
    dataset = of(xr.load_dataset(measured), problem="straight path")
    G = dataset.error.sel(quantity="G")
    coarse, fine, default = range(3)
    assert list(dataset.part) == ["path", "path", "default"]
    assert G[default] < 0.003 < G[fine] < G[coarse] < 0.2
    assert dataset.distance[default] < 0.1 < dataset.distance[coarse] < 10.0
    shear = of(xr.load_dataset(measured), problem="shear path")
    assert np.isfinite(shear.distance).all()
    assert np.isnan(shear.error).all()


def grown(errors, grids):
    """Synthetic paths: errors on some grids by (order, direction)."""
    rows = [
        (way, grid, error, "path")
        for way, found in errors.items()
        for grid, error in zip(grids, found, strict=True)
    ]
    rows.append(((1.0, "max_hoop"), "graded", 1.0, "default"))
    ways, sizes, error, part = zip(*rows, strict=True)
    n = len(rows)
    return xr.Dataset(
        {
            "cpu": ("run", np.ones(n)),
            "error": (("run", "quantity"), np.full((n, 4), np.nan)),
            "distance": ("run", np.array(error)),
        },
        {
            "quantity": ["G", "J", "K_I", "K_II"],
            "problem": ("run", ["path"] * n),
            "program": ("run", ["cfmpm"] * n),
            "part": ("run", list(part)),
            "series": ("run", [""] * n),
            **{key: ("run", ["T6"] * n) for key in ("element", "tip_size", "growth", "refine")},
            "size": ("run", list(sizes)),
            "order": ("run", [order for order, _ in ways]),
            "direction": ("run", [direction for _, direction in ways]),
        },
        {"axes": "order direction", "ways": "order direction"},
    )


def test_ways_to_grow_are_compared_on_the_same_grids():
    """By the geometric mean over grids that were run with all options."""
    default, other = (1.0, "max_hoop"), (2.0, "cf")
    dataset = grown({default: [1.0, 2.0], other: [0.1, 3.2]}, ["a", "b"])
    beside = grown({other: [1e-9]}, ["c"]).isel(run=[0])
    head, rows, classes = defaults._ways(xr.concat([dataset, beside], "run"))
    assert head == ["order", "direction", "path", "all", "worst problem", "verdict"]
    assert rows[0][2:] == ["1.00 (1.00 to 1.00, 2 grids)", "1.00", "1.00", "the default"]
    told = ["0.40 (0.10 to 1.60, 2 grids)", "0.40", "0.40", "another is better"]
    assert rows[1] == ["2.0", "cf", *told]
    assert classes == ["yes", "no"]
    even = grown({default: [1.0, 2.0], other: [0.5, 2.0]}, ["a", "b"])
    assert defaults._ways(even)[1][1][-2:] == ["0.71", "stays"]


def runs(cost, error, part):
    """Synthetic gradings of a problem: T6 of one size and several tip sizes."""
    # The problem is one that scikit-fem has solved too.
    cost, error, part = [*cost, 1.0], [*error, 1.0], [*part, "beside"]
    n = len(cost)
    return xr.Dataset(
        {
            "cpu": ("run", cost),
            "error": (("run", "quantity"), np.outer(error, [1.0, 9.0, 0.5, 0.1])),
            "distance": ("run", np.full(n, np.nan)),
        },
        {
            "quantity": ["G", "J", "K_I", "K_II"],
            "problem": ("run", ["plate"] * n),
            "program": ("run", ["cfmpm"] * (n - 1) + ["scikit-fem"]),
            "part": ("run", part),
            "series": ("run", [""] * n),
            "element": ("run", ["T6"] * n),
            "size": ("run", np.ones(n)),
            "tip_size": ("run", 10.0 ** -np.arange(n)),
            "growth": ("run", np.full(n, 0.3)),
            "formulation": ("run", ["total"] * n),
        },
        {"axes": "formulation", "ways": ""},
    )


@pytest.mark.parametrize(
    ("cost", "error", "verdict"),
    [
        ([1.0, 1.05, 9.0], [1e-3, 0.6e-3, 1e-6], "stays"),
        ([1.0, 1.05, 9.0], [1e-3, 0.4e-3, 1e-6], "another is better"),
        ([1.0, 1.20, 9.0], [1e-3, 0.4e-3, 1e-6], "stays"),
        ([1.0, 0.20, 9.0], [1e-3, 0.4e-3, 1e-6], "another is better"),
    ],
)
def test_verdict_follows_the_data(tmp_path, cost, error, verdict):
    path, page = tmp_path / "runs.nc", tmp_path / "page.html"
    runs(cost, error, ["default", "grading", "grading"]).to_netcdf(path)
    defaults.write_defaults(path, {}, page)
    text = page.read_text(encoding="utf-8")
    assert f"<td>{verdict}</td>" in text
    told = "better" if verdict == "another is better" else ""
    ratios = f"{cost[1] / cost[0]:.2f}</td><td>{error[1] / error[0]:.3f}"
    assert f"<td>{ratios}</td><td>{told}</td>" in text


def test_pareto_front():
    assert pareto_front([3, 1, 2, 4, 2], [1, 5, 3, 1, 4]).tolist() == [1, 2, 0]
    assert pareto_front([1, 1, np.nan, 2], [2, 1, 0.1, np.nan]).tolist() == [1]
    assert pareto_front([], []).tolist() == []


def test_axes():
    axes = {"a": [1, 2], "b": ["x", "y", "z"]}
    values = list(each_value(axes))
    assert values[0] == {"a": 1, "b": "x"}
    assert {one["a"] for one in values} == {1, 2}
    assert {one["b"] for one in values} == {"x", "y", "z"}
    assert len(values) == 4


def test_scaling(scene_file, tmp_path):
    path = tmp_path / "scaling.nc"
    grids = [{"element": "T3", "size": size, "grading": "uniform"} for size in (80, 50)]
    series = {"T3": grids, "T6": [{**mesh, "element": "T6"} for mesh in grids]}
    scaling.measure(path, scene_file, solver="superlu", repeats=1, threads=[1, 2], series=series)
    dataset = xr.load_dataset(path)
    assert dict(dataset.sizes) == {"element": 2, "threads": 2, "rank": 2, "phase": 5}
    assert np.isfinite(dataset.exponent).all()
    assert (dataset.memory > 50).all()
    assert (dataset.n_points.diff("rank") > 0).all()
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
        meshes=[{"element": element, "size": 80, "grading": "uniform"} for element in ("T3", "T6")],
    )
    dataset = xr.load_dataset(path)
    assert list(dataset.element.values) == ["T3", "T6"]
    assert list(dataset.part.values) == list(newton_cost.PARTS)
    assert (dataset.microseconds > 0).all()
    assert (dataset.whole > 0).all()


def test_study_overhead(tmp_path):
    path = tmp_path / "overhead.nc"
    study_overhead.measure(
        path,
        "configs/paper/single_edge_crack.yaml",
        replaced={"mesh.size": 80},
        lengths=2,
        stiffnesses=2,
        workers=[1, 2],
    )
    dataset = xr.load_dataset(path)
    assert dataset.workers.values.tolist() == [1, 2]
    assert (dataset.members == 4).all()
    for name in ("overhead", "member_time", "wall_time", "file_size", "n_points"):
        assert (dataset[name] > 0).all(), name


def test_a_run_alone_that_fails_says_so(scene_file):
    with pytest.raises(RuntimeError, match="size"):
        run_alone(scene_file, {"mesh.size": -1}, threads=1, repeats=1)
