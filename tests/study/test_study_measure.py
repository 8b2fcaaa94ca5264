"""Variants, additional quantities and repeated runs of members."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from study_texts import STUDY, write_study

import cfmpm
import cfmpm.accessor
from cfmpm.errors import SceneError
from cfmpm.study import member
from cfmpm.study.collecting import collect
from cfmpm.study.member import solve
from cfmpm.study.reading import Plan, load_study, study_from_dict
from cfmpm.study.solving import solve_studies, solve_study

VARIANTS = """\
name: compared
base: small.yaml
replace: {mesh.size: 3}
product:
  variant:
    variants:
      as_is: {}
      finer: {mesh.size: 2, mesh.element: T6}
      same: {mesh.size: 3}
  E: {key: material.E, values: [1e5, 2e5]}
"""
# Of the whole plate, of its nodes, and one with labels of its own.
GAUGE = """\
import numpy as np
import xarray as xr

CALLS = []


def gauge(result):
    nodes = result.grid.nodes
    return xr.Dataset(
        {
            "n_places": ((), len(nodes), {"units": "1", "long_name": "nodes"}),
            "node_x": ("node", nodes[:, 0]),
            "extent": ("axis", np.ptp(nodes, axis=0)),
        },
        {"axis": ["x", "y"]},
    )


def taken(result):
    return xr.Dataset({"K_I": 1.0})


def text(result):
    return xr.Dataset({"word": "high"})


def parameter(result):
    return xr.Dataset({"length": 1.0})


def fails(result):
    raise ValueError("no gauge here")
"""


def solved(plan: Plan) -> xr.Dataset:
    """In this process."""
    return collect(plan, {one.key: solve(one.job()) for one in plan.members})


def measuring(folder: Path, function: str) -> Plan:
    (folder / "gauge.py").write_text(GAUGE)
    return load_study(write_study(folder, f"{STUDY}measure: gauge.py:{function}\n"))


def test_variants_are_one_dimension(tmp_path: Path) -> None:
    """Each variant replaces keys of the base; its name is its label."""
    plan = load_study(write_study(tmp_path, VARIANTS))
    assert [one.values["variant"] for one in plan.members[::2]] == ["as_is", "finer", "same"]
    assert [one.scene.mesh.size for one in plan.members[::2]] == [3, 2, 3]
    assert [one.scene.mesh.element for one in plan.members[::2]] == ["T3", "T6", "T3"]
    # Equal scenes are solved once.
    assert plan.members[0].key == plan.members[4].key != plan.members[2].key
    data = solved(plan)
    assert dict(data.J.sizes) == {"variant": 3, "E": 2, "tip": 1}
    assert data.variant.attrs == {"long_name": "variant of the scene"}
    one = data.sel(variant="finer", E=2e5)
    assert float(one.J[0]) == float(cfmpm.run(plan.members[3].scene).history.J[0, 0])
    assert one.cfmpm.scene == plan.members[3].scene


REFUSED = [
    # text, changed to; line, key, words
    ("finer: {mesh.size: 2,", "finer: {mesh.size: -2,", 5, "mesh.size", "greater than 0"),
    ("mesh.element: T6}", "mesh.elemnt: T6}", 5, "mesh.elemnt", "did you mean element?"),
    ("mesh.element: T6}", "material.E: 1e5}", 10, "product.E.key", "is what variant sets"),
    ("mesh.element: T6}", "mesh..size: 1}", 8, "product.variant.variants", "not a key such as"),
    ("  variant:\n", "  variant:\n    key: mesh\n", 6, "product.variant.key", "keys of their own"),
    ("  variant:\n", "  variant:\n    values: [1]\n", 5, "product.variant", "needs one of"),
]


@pytest.mark.parametrize(("old", "new", "line", "key", "words"), REFUSED)
def test_bad_variants(old, new, line, key, words, tmp_path: Path) -> None:
    assert VARIANTS.count(old) == 1
    with pytest.raises(SceneError) as error:
        load_study(write_study(tmp_path, VARIANTS.replace(old, new)))
    told = [(p.line, p.key, p.reason) for p in error.value.problems]
    assert any(
        at == line and (of or "").startswith((key, "member", "in ")) and key in f"{of} {why}"
        and words in why
        for at, of, why in told
    ), told  # fmt: skip


def test_what_is_measured_is_in_the_dataset(tmp_path: Path) -> None:
    """Padded with nan if members differ in size, with labels if these are equal."""
    plan = measuring(tmp_path, "gauge")
    data = solved(plan)
    assert (data.reason == "").all(), data.reason.values
    assert data.n_places.attrs == {"units": "1", "long_name": "nodes"}
    assert dict(data.extent.sizes) == {"length": 2, "E": 2, "axis": 2}
    np.testing.assert_allclose(data.extent.sel(axis="y"), 20.0)
    known = data.node_x.notnull().sum("node")
    assert (known == data.n_places).all()
    assert data.sizes["node"] == int(data.n_places.max()) > int(data.n_places.min())
    # In processes of their own.
    again = solve_study(plan, 2)
    xr.testing.assert_equal(*(one.drop_vars(["run_time", "cpu_time"]) for one in (data, again)))


def test_the_measure_of_the_readme(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "configs" / "studies" / "README.md").read_text("utf-8")
    (code,) = re.findall(r"```python\n(.*?def displacement\(.*?)```", text, re.DOTALL)
    (tmp_path / "gauge.py").write_text(code)
    plan = load_study(write_study(tmp_path, f"{STUDY}measure: gauge.py:displacement\n"))
    outcome = solve(plan.members[0].job())
    assert outcome.status == "done", outcome.reason
    assert outcome.quantities["u_gauge"][1].shape == (2,)
    assert outcome.labels["axis"] == ["x", "y"]


def test_a_member_is_known_by_what_measures_it(tmp_path: Path) -> None:
    plan = measuring(tmp_path, "gauge")
    keys = {one.key for one in plan.members}
    assert keys.isdisjoint(one.key for one in measuring(tmp_path, "fails").members)
    assert keys.isdisjoint(one.key for one in load_study(write_study(tmp_path, STUDY)).members)
    (tmp_path / "gauge.py").write_text(GAUGE + "# changed\n")
    changed = load_study(write_study(tmp_path, f"{STUDY}measure: gauge.py:gauge\n"))
    assert keys.isdisjoint(one.key for one in changed.members)


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        ("taken", "K_I is a name in the dataset of every study"),
        ("text", "word is no number"),
        ("fails", "ValueError: no gauge here"),
    ],
)
def test_a_measure_that_fails_is_the_reason(tmp_path: Path, function: str, reason: str) -> None:
    outcome = solve(measuring(tmp_path, function).members[0].job())
    assert outcome.status == "failed"
    assert reason in outcome.reason
    assert not outcome.lasting
    assert "J" in outcome.quantities


def test_a_measure_takes_no_name_of_a_parameter(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"length: .*by the name of a parameter"):
        solved(measuring(tmp_path, "parameter"))


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("gauge.py:guage", "there is no function guage in"),
        ("guage.py:gauge", "cannot be read"),
        ("no.such.module:f", "no module no.such.module can be imported"),
        ("gauge.py", "must be file.py:function or package.module:function"),
    ],
)
def test_a_measure_that_is_not_there(tmp_path: Path, place: str, words: str) -> None:
    """It is reported before any member runs, with its line."""
    (tmp_path / "gauge.py").write_text(GAUGE)
    with pytest.raises(SceneError) as error:
        load_study(write_study(tmp_path, f"{STUDY}measure: {place}\n"))
    (problem,) = error.value.problems
    assert (problem.key, problem.line) == ("measure", STUDY.count("\n") + 1)
    assert words in problem.reason


def test_the_fastest_of_repeated_runs_counts(tmp_path: Path, monkeypatch) -> None:
    """Three runs that take 3, 1 and 2 seconds."""
    plan = load_study(write_study(tmp_path, f"{STUDY}repeats: 3\n"))
    wall, cpu = iter([0.0, 0.0, 3.0, 3.0, 4.0, 4.0, 6.0]), iter([0, 0, 6, 6, 8, 8, 12])
    clock = SimpleNamespace(perf_counter=lambda: next(wall), process_time=lambda: next(cpu))
    monkeypatch.setattr(member, "time", clock)
    outcome = solve(plan.members[0].job())
    assert (outcome.seconds, outcome.cpu_seconds) == (1.0, 2.0)


def test_studies_without_a_file(tmp_path: Path) -> None:
    """Several studies: common members are solved once; problems have their keys."""
    write_study(tmp_path, STUDY)
    study = {
        "name": "a",
        "base": "small.yaml",
        "zip": {"E": {"key": "material.E", "values": [1e5]}},
    }
    seen = []
    plans = [study_from_dict(study | {"name": name}, tmp_path) for name in ("a", "b")]
    one, other = solve_studies(plans, 1, seen.append)
    assert len(seen) == 1
    xr.testing.assert_equal(one, other)
    assert json.loads(other.study)["name"] == "b"
    bad = study | {"base": {"name": "none"}}
    with pytest.raises(SceneError, match="material"):
        study_from_dict(bad, tmp_path)
