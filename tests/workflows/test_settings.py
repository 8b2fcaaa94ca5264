"""A configuration that does not suffice for figures or claims is refused."""

from __future__ import annotations

import copy
import json

import growth_data as made_up
import pytest
import yaml
from pydantic import ValidationError
from ruamel.yaml import YAML

from workflows.growth.settings import GROWN, Growth
from workflows.large_strain.laws_figure import HENCKY, NEO_HOOKEAN, STRESS
from workflows.large_strain.settings import PULLED
from workflows.settings import Settings

BLOCKS = (
    *("section_5_1", "growth", "large_strain", "work_precision"),
    *("scaling", "newton_cost", "study_overhead", "stability"),
)


@pytest.fixture(scope="module")
def shipped(root):
    config = {}
    for name in BLOCKS:
        path = root / "configs" / "workflow" / f"{name}.yaml"
        config |= yaml.safe_load(path.read_text(encoding="utf-8"))
    return config


@pytest.fixture
def config(shipped):
    return copy.deepcopy(shipped)


def refused(config, *words):
    with pytest.raises(ValidationError) as error:
        Settings.model_validate(config)
    (one,) = error.value.errors()
    assert all(word in f"{one['loc']}: {one['msg']}" for word in words), one


@pytest.fixture
def without(root, tmp_path):
    """Replace a study by a copy without some values of a parameter."""

    def change(block, parameter, *missing):
        path = root / block["study"]
        study = YAML(typ="safe", pure=True).load(path)
        study["base"] = str(path.parent / study["base"])
        one = study["product"][parameter]
        of = one.get("variants") or one["values"]
        for name in missing:
            del of[name]
        for name, value in of.items():
            if isinstance(value, str):  # a block of another file
                of[name] = str(path.parent / value)
        if isinstance(study.get("replace"), str):
            study["replace"] = str(path.parent / study["replace"])
        changed = tmp_path / path.name
        changed.write_text(json.dumps(study), encoding="utf-8")
        return {**block, "study": str(changed)}

    return change


@pytest.mark.parametrize(
    ("study", "variant"), [(study, name) for study, names in GROWN.items() for name in names]
)
def test_a_growth_variant_that_is_missing(config, without, study, variant):
    block = config["growth"][study]
    block["film"]["variant"] = next(name for name in GROWN[study] if name != variant)
    config["growth"][study] = without(block, "variant", variant)
    refused(config, "growth", f"{study}.variants: figures and claims need {variant}")


@pytest.mark.parametrize(("study", "label"), [("edge", "twice"), ("beam", "domains")])
def test_what_is_missing_of_many_grids(config, without, study, label):
    block = config["growth"][study]
    changed = without({"study": block["scatter"]}, "how", label)
    config["growth"][study] = {**block, "scatter": changed["study"]}
    refused(config, "growth", f"{study}.scatter.how: figures and claims need {label}")


@pytest.mark.parametrize("variant", PULLED)
def test_a_large_strain_variant_that_is_missing(config, without, variant):
    config["large_strain"] = without(config["large_strain"], "variant", variant)
    refused(config, "large_strain", f"variants: figures and claims need {variant}")


def test_what_is_needed_is_what_figures_and_claims_are_tested_with():
    """All figures can be drawn from synthetic data of these variants and sizes only."""
    drawn = {*HENCKY, *NEO_HOOKEAN, *STRESS}
    assert set(PULLED) == drawn | {"hencky_uniform_dead", "hencky_domains"}
    for study, names in GROWN.items():
        made = set(getattr(made_up, study)().variant.values)
        sized = {name for name in made if "first_" in name or "second_" in name}
        assert set(names) <= made
        assert made - sized <= set(names)


def test_sizes_of_the_near_miss_are_those_of_the_variants(config, without):
    growth, beam = config["growth"], config["growth"]["beam"]
    assert Growth(**growth).near_miss_sizes() == [12, 8, 5, 3]
    growth["beam"] = without(beam, "variant", "second_12")
    refused(config, "growth", "beam.variants: figures and claims need second_12")
    growth["beam"] = without(beam, "variant", "first_12", "second_12")
    assert Growth(**growth).near_miss_sizes() == [8, 5, 3]
    growth["beam"] = without(beam, "variant", *(f"first_{size}" for size in (12, 8, 5, 3)))
    refused(config, "growth", "beam.variants: figures and claims need first_")


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("drawn", ["T3_384", "T3_500"], "grids: figures and claims need T3_500"),
        ("swept", [384, 500], "T3: figures and claims need 500"),
        ("swept", [384], "swept"),
        ("domain_radius", 55.0, "radii: figures and claims need 55.0"),
    ],
)
def test_section_5_1_shows_what_it_computes(config, key, value, told):
    config["section_5_1"][key] = value
    refused(config, "section_5_1", told)


def test_section_5_1_compares_its_series(config, without):
    block = config["section_5_1"]
    config["section_5_1"] = without(block, "grid", "T6_790")
    refused(config, "section_5_1", "T6: figures and claims need 790")
    graded = [f"T6_graded_{n}" for n in (600, 1400, 3500, 8000)]
    config["section_5_1"] = without(block, "grid", *graded)
    refused(config, "section_5_1", "series: figures and claims need T6_graded")
