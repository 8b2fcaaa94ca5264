"""The stability study: criteria of its cases, and its page."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from pydantic import ValidationError

from cfmpm.meshing import triangulate
from cfmpm.scene import load_scene
from cfmpm.simulation import run
from workflows.stability.cases import write_cases
from workflows.stability.page import write_page
from workflows.stability.path_of_load import path_of_load
from workflows.stability.settings import Stability
from workflows.stability.slivers import CRACK, HEIGHT, WIDTH, write_plate

SCENE = "configs/paper/large_strain.yaml"
COARSE = {
    "mesh": {"element": "T3", "size": 200, "grading": "uniform"},
    "fracture.radii": 1,
    "loads": [
        {"edge": "bottom", "displacement": {"y": -5}},
        {"edge": "top", "displacement": {"y": 5}},
    ],
    "load_steps": 1,
}


def group(**cases):
    return {"scene": SCENE, "groups": {"g": {"title": "A <group>", "replaced": COARSE} | cases}}


CASES = {
    "cases": {
        "tension": {},
        "stiffer": {"replaced": {"material.E": 420e3}, "as_case": "g/tension", "times": 2,
                    "within": 1e-9},
        "wrong": {"replaced": {"material.E": 420e3}, "as_case": "g/tension", "within": 1e-9},
        "pressed": {"replaced": {"load_steps": [-1]}, "as_case": "g/tension", "vanishes": True,
                    "within": 1e-6},
        "refused": {"replaced": {"family.crack_length": 0.05}, "ends": "refused"},
        "not_refused": {"ends": "refused"},
        "past_its_end": {"replaced": {"load_steps": [-60]}, "ends": "unstable"},
    }
}  # fmt: skip


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("stability") / "cases.nc"
    write_cases(group(**CASES), 1, path)
    return path


def test_what_misses_its_reference_or_its_ending_has_not_held(study):
    data = xr.load_dataset(study)
    held = {str(name).split("/")[1]: bool(value) for name, value in data.held.to_series().items()}
    assert held == dict.fromkeys(CASES["cases"], True) | {"wrong": False, "not_refused": False}
    assert float(data.error.sel(case="g/wrong")) == pytest.approx(1.0)
    assert (data.not_known == 0).all()


def test_unknown_numbers_are_counted():
    """Check of the check: a history with a missing value."""
    result = run(load_scene(SCENE, COARSE))
    assert int(path_of_load(result).not_known) == 0
    result.history["J"][0] = np.nan
    assert int(path_of_load(result).not_known) == 1


def test_the_page_says_what_happened(study, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "workflows.stability.page.PATHS",
        {title: {"g/past_its_end": "pressed"} for title in ("A", "B", "Reversal")},
    )
    pictures = [tmp_path / "errors.png", tmp_path / "paths.png"]
    write_page(study, {"g": "A <group>"}, *pictures, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "A &lt;group&gt;" in page
    assert "5 of 7 cases ended as they should" in page
    assert "it must be on it, or at least" in page
    assert "no stable state was found" in page
    assert page.count("data:image/png") == 2
    assert all(picture.stat().st_size > 1000 for picture in pictures)


def test_a_case_is_compared_with_one_above_it():
    with pytest.raises(ValidationError, match="no case g/tension above it"):
        Stability.model_validate(
            group(cases={"first": {"as_case": "g/tension"}, "tension": {}}),
        )


@pytest.mark.parametrize(("kind", "thinness"), [("none", 1.0), ("needles", 1e-3), ("caps", 1e-3)])
def test_slivers_are_as_thin_as_said(tmp_path, kind, thinness):
    """They fill the plate, and the thinnest one has the requested height."""
    write_plate(tmp_path / "plate.msh", kind, thinness)
    scene = load_scene(
        SCENE,
        {
            "family": None,
            "mesh_file": {"file": str(tmp_path / "plate.msh"), "cracks": ["crack"]},
            "mesh": {"element": "T3"},
        },
    )
    mesh = triangulate(scene)
    corners = mesh.nodes[mesh.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    longest = np.max([np.hypot(*side.T) for side in (a, b, a - b)], axis=0)
    assert area.sum() == pytest.approx(WIDTH * HEIGHT)
    assert set(mesh.edges) == {"bottom", "right", "top", "left"}
    crack = mesh.nodes[mesh.cracks["crack"]]
    assert np.hypot(*(crack[:, 1] - crack[:, 0]).T).sum() == pytest.approx(CRACK)
    height = float((2.0 * area / longest**2).min())
    if kind == "none":
        assert height == pytest.approx(0.5)
    else:
        assert 0.3 * thinness < height < 1.5 * thinness
