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
from workflows.stability.closed_forms import (
    double_cantilever_rate,
    edge_crack_cycles,
    edge_crack_rate,
)
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
PULL = [{"edge": "bottom", "traction": [0, -100]}, {"edge": "top", "traction": [0, 100]}]
GROWS = {
    "kinematics": "small",
    "mesh": {"element": "T3", "size": 60, "grading": "uniform"},
    "material.g_c": 1e-3,
    "growth": {"direction": "cf", "increments": 2},
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
        "grows_straight": {"replaced": GROWS, "compared": "aside", "exact": 1.0, "vanishes": True,
                           "within": 0.05},
        "along": {"replaced": {**GROWS, "loads": PULL}, "along": "edge_crack_rate", "within": 0.3},
        "coarse": {"replaced": {**GROWS, "loads": PULL}, "along": "edge_crack_rate",
                   "within": 0.001},
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
    assert held == dict.fromkeys(CASES["cases"], True) | dict.fromkeys(
        ("wrong", "not_refused", "coarse"), False
    )
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
    assert "7 of 10 cases ended as they should" in page
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


def test_closed_forms_of_growing_cracks():
    """Paris' law by another rule of integration, the limits of short cracks and long arms."""
    strip = {
        "family": None,
        "geometry.outline": [
            {"at": at, "edge": edge}
            for at, edge in (
                ([0, 0], "bottom"),
                ([50, 0], "right"),
                ([50, 300], "top"),
                ([0, 300], "left"),
            )
        ],
        "geometry.cracks": [{"points": [[0, 150], [10, 150]]}],
        "kinematics": "small",
        "load_steps": 1,
        "loads": PULL,
        "fracture.radii": 1,
        "growth": {"control": "fatigue"},
        "fatigue": {"C": 1e-12, "m": 3, "load_ratio": 0.5},
    }
    scene = load_scene(SCENE, strip)
    modulus, factor = 210e3 / (1 - 0.3**2), np.array([1.0, 1.0, 2.0])
    length = np.array([10.0, 11.0, 13.0])
    G = edge_crack_rate(scene, length, factor)
    K = np.sqrt(modulus * edge_crack_rate(scene, np.linspace(10, 13, 3001), 1.0))
    lives = edge_crack_cycles(scene, length, factor)
    assert lives[0] == 0.0
    assert lives[2] == pytest.approx(3.0 * np.mean(1.0 / (1e-12 * (0.5 * K) ** 3)), rel=1e-3)
    assert G[2] == pytest.approx(4.0 * K[-1] ** 2 / modulus)
    short = np.sqrt(modulus * edge_crack_rate(scene, np.array([1e-3]), 1.0)[0])
    assert short == pytest.approx(1.122 * 100.0 * np.sqrt(np.pi * 1e-3), rel=2e-3)

    arms = [
        {"name": name, "box": [[-1, low], [0, low + 150]], "displacement": {"y": y}}
        for name, low, y in (("top", 150, 0.5), ("bottom", 0, -0.5))
    ]
    held = {"edge": "right", "displacement": {"x": 0}}
    beam = load_scene(SCENE, strip | {"loads": [*arms, held], "growth": None, "fatigue": None})
    a, h = np.array([1e5]), 150.0
    # Slender arms of an isotropic material: G = 3 E' d^2 h^3 / (16 a^4).
    slender = 3.0 * modulus * h**3 / (16.0 * a**4)
    assert double_cantilever_rate(beam, a, 1.0) == pytest.approx(slender, rel=5e-3)
